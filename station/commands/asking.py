"""`station import --ask`: the columns of a file, what they seem to be, and a line to correct it."""

import re
import sys
from pathlib import Path
from typing import Any

import click
from pydantic import ValidationError
from rich.table import Table as Grid
from rich.text import Text

from daq.importing.apply import matched
from daq.importing.errors import ImportProblem
from daq.importing.options import ImportOptions
from daq.importing.propose import Doubtful, Proposal
from daq.importing.reading import Look, look_at
from daq.importing.recipe import ROLES, Column, Recipe
from station.exits import UsageProblem
from station.output import screen

FIRST_ROWS = 4
HELP = "Enter: looks right. Or as  2=displacement mm,  3=ignored,  displacement=mm,  rate=100"
WORDS = ("rate", "time", "displacement", "velocity", "acceleration", "force")
_CORRECTION = re.compile(r"\s*(\d{1,4}|[a-z]+)\s*=\s*(\S+)\s*(.*?)\s*")


def asked(file: Path, options: ImportOptions) -> Recipe:
    """Show the columns of a file until the operator finds that they look right, and return the recipe for it."""
    if not sys.stdin.isatty():
        raise UsageProblem(
            "--ask needs a terminal; without one --accept takes what is proposed, and --recipe a file"
        )
    look = look_at(file, options)
    try:
        recipe = look.read().recipe
    except Doubtful as refusal:
        screen().print(Text(str(refusal)))
        recipe = refusal.proposal.recipe
    while True:
        _show(look, recipe)
        line = click.prompt(HELP, default="", show_default=False, prompt_suffix="\n> ")
        try:
            if line.strip():
                recipe = corrected(look, recipe, line)
                continue
            Look(look.table, Proposal(recipe, {})).read()
            return recipe
        except (ImportProblem, UsageProblem) as refusal:
            screen().print(Text(str(refusal), style="bold"))
            recipe = refusal.proposal.recipe if isinstance(refusal, Doubtful) else recipe


def corrected(look: Look, recipe: Recipe, line: str) -> Recipe:
    """Return a recipe after a correction as it is typed. Raises UsageProblem, in a sentence, where it is none."""
    match = _CORRECTION.fullmatch(line)
    name, value, unit = match.groups() if match else ("", "", "")
    number = int(name) if name.isdigit() else None
    if match is None or (number is not None and value not in ROLES) or (number is None and name not in WORDS):
        raise UsageProblem(
            f"{line.strip()} is no correction: NUMBER=ROLE UNIT, with a role of {', '.join(ROLES)}"
        )
    if number is not None and number not in [column.number for column in look.table.columns]:
        raise UsageProblem(f"there is no column {number}")
    fields = matched(look.table, recipe)
    old = fields.get(number or 0, Column(column=number or 1))
    said: dict[str, Any] = recipe.model_dump(by_alias=True)
    if name == "rate":
        said["rate"] = value
    elif number is None:
        said["fields"] = [f | ({"unit": value} if f["role"] == name else {}) for f in said["fields"]]
    else:
        kept = old.unit if value == old.role else ""
        new = old.model_dump(by_alias=True) | {"role": value, "unit": unit or kept}
        there = old in recipe.fields
        fields_now = [new if f is old else s for f, s in zip(recipe.fields, said["fields"], strict=True)]
        said["fields"] = fields_now if there else [*fields_now, new]
    try:
        return Recipe.model_validate(said)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        raise UsageProblem(first["msg"].removeprefix("Value error, ")) from None


def _show(look: Look, recipe: Recipe) -> None:
    fields = matched(look.table, recipe)
    grid = Grid("", "column", "first numbers", "role", "unit", "run", box=None, padding=(0, 1))
    for column in look.table.columns:
        field = fields.get(column.number, Column(column=column.number))
        numbers = "  ".join(f"{value:.5g}" for value in column.values[:FIRST_ROWS])
        cells = (str(column.number), column.label, numbers, field.role, field.unit, field.run)
        grid.add_row(*(Text(cell, overflow="ellipsis", no_wrap=True) for cell in cells))
    console = screen()
    console.print(grid)
    if recipe.rate is not None:
        console.print(f"rate: {recipe.rate:g} Hz")
