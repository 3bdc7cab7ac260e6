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
HELP = "Enter: looks right. Else a correction, as  2=displacement mm  or  3=ignored  or  rate=100"
_CORRECTION = re.compile(r"\s*(\d+|rate)\s*=\s*(\S+)\s*(.*?)\s*")


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
    if match is None or (match[1] != "rate" and match[2] not in ROLES):
        raise UsageProblem(
            f"{line.strip()} is no correction: NUMBER=ROLE UNIT, with a role of {', '.join(ROLES)}"
        )
    fields = matched(look.table, recipe)
    numbers = [column.number for column in look.table.columns]
    try:
        if match[1] == "rate":
            return Recipe.model_validate({**_said(recipe), "rate": match[2]})
        if int(match[1]) not in numbers:
            raise UsageProblem(f"there is no column {match[1]}")
        old = fields.get(int(match[1]), Column(column=int(match[1])))
        new = Column.model_validate(
            {
                **old.model_dump(by_alias=True),
                "role": match[2],
                "unit": match[3] or old.unit * (match[2] == old.role),
            }
        )
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        raise UsageProblem(first["msg"].removeprefix("Value error, ")) from None
    fields_left = [new if field is old else field for field in recipe.fields]
    return recipe.model_copy(update={"fields": (*fields_left, *(() if old in recipe.fields else (new,)))})


def _said(recipe: Recipe) -> dict[str, Any]:
    return recipe.model_dump(by_alias=True)


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
