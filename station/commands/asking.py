"""`station import --ask`: the recipe that is proposed for a file, in the operator's editor."""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import click

from daq.importing.errors import ImportProblem
from daq.importing.options import ImportOptions
from daq.importing.propose import Doubtful, Proposal
from daq.importing.reading import Look, look_at
from daq.importing.recipe import ROLES, Recipe, read_recipe, to_toml
from daq.session_reading import RECIPE
from station.exits import UsageProblem

FIRST_ROWS = 4


def asked(file: Path, options: ImportOptions) -> Recipe:
    """Open the recipe that is proposed for a file in an editor, until the file can be read by it; return it.

    Above it stand the columns with their first numbers. UsageProblem where the operator empties it, or without a terminal.
    """
    if not sys.stdin.isatty():
        raise UsageProblem(
            "--ask needs a terminal; without one --accept takes what is proposed, and --recipe a file"
        )
    look = look_at(file, options)
    remark = "Correct what is wrong, save, and leave the editor. Empty the file to import nothing."
    try:
        text = to_toml(look.read().recipe)
    except Doubtful as refusal:
        remark, text = f"{refusal}\n{remark}", to_toml(refusal.proposal.recipe)
    head = [f"Roles: {', '.join(ROLES)}.", "The columns and their first numbers:"]
    for column in look.table.columns:
        numbers = ", ".join(f"{value:.5g}" for value in column.values[:FIRST_ROWS])
        head.append(f"{column.number:>3} {column.label}: {numbers}")
    text = _commented("\n".join(head)) + text
    with TemporaryDirectory() as folder:
        place = Path(folder) / RECIPE
        while True:
            place.write_text(_commented(remark) + text, encoding="utf-8")
            click.edit(filename=str(place))
            text = place.read_text(encoding="utf-8").removeprefix(_commented(remark))
            if not text.strip():
                raise UsageProblem(f"{file}: the recipe was emptied; nothing was imported")
            try:
                recipe = read_recipe(place)
                Look(look.table, Proposal(recipe, {})).read()
                return recipe
            except ImportProblem as refusal:
                remark = str(refusal)


def _commented(text: str) -> str:
    return "".join(f"# {line}\n" for line in text.splitlines())
