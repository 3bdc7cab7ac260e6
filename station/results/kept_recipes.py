"""Recipes of files: confirmed once, kept in each session and found for the next file of that shape; or asked for."""

import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import click

from daq.importing.apply import fits
from daq.importing.errors import ImportProblem
from daq.importing.options import ImportOptions
from daq.importing.propose import Doubtful, Proposal
from daq.importing.reading import Look, look_at, read_table
from daq.importing.recipe import ROLES, Part, Recipe, read_recipe, to_toml
from daq.importing.table import Table
from daq.session_reading import RECIPE
from station.exits import UsageProblem

MOST = 200
"""Sessions whose recipes are looked at, the newest first."""

NONE = "none"
FIRST_ROWS = 4


def look_with_kept(file: Path, sessions: Path, options: ImportOptions) -> tuple[Look, str]:
    """Return a file with the newest confirmed recipe in `sessions` that fits it, and a sentence on it; without any, with
    what is proposed. A file is known by the names of its columns and the units that it states; of one without names that
    leaves a doubt the recipe is only proposed. With options that say how it is read no recipe is looked for.
    """
    if replace(options, accept=False) != ImportOptions():
        return look_at(file, options), ""
    tables: dict[str, Table | None] = {}
    for place, recipe in _confirmed(sessions):
        in_text = recipe.format in ("text", "serial", "json")
        written = recipe.model_copy(update={"fields": ()}) if in_text else recipe
        key = written.model_dump_json(exclude={"rate", "resample", "even", "restarts"})
        if key not in tables:
            tables[key] = None
            with suppress(ImportProblem):
                tables[key] = read_table(file, written)
        table = tables[key]
        if table is None or not fits(table, recipe):
            continue
        kept = f"the recipe that was confirmed for {place.parent.name}"
        without = f"({place}); --recipe none reads the file without it"
        if any(field.name for field in recipe.fields):
            return Look(
                table, Proposal(recipe, {})
            ), f"read by {kept}, whose columns and units are the same {without}"
        doubt = (
            f"its columns have no names; it would be read by {kept} "
            "(--accept takes that, --recipe none reads the file without it)"
        )
        proposed = Look(table, Proposal(recipe, {}, (doubt,)))
        in_doubt = isinstance(_refusal(lambda: look_at(file).read()), Doubtful)
        if in_doubt and _refusal(partial(proposed.read, accept=True)) is None:
            return proposed, f"read by {kept} {without}"
    return look_at(file), ""


def _refusal(read: Callable[[], object]) -> ImportProblem | None:
    try:
        read()
    except ImportProblem as refusal:
        return refusal
    return None


def _confirmed(sessions: Path) -> list[tuple[Path, Recipe]]:
    """Return the confirmed recipes of the newest sessions, each once, without what is of one file only."""
    places = [(place.stat().st_mtime, place) for place in sessions.glob(f"*/{RECIPE}") if place.is_file()]
    found: dict[str, tuple[Path, Recipe]] = {}
    for _, place in sorted(places, reverse=True)[:MOST]:
        try:
            recipe = read_recipe(place)
        except ImportProblem:
            continue
        if recipe.confirmed and recipe.fields:
            parts = () if any(part != Part() for part in recipe.parts) else recipe.parts
            # A rate beside a column of times is that of these very stamps.
            stamped = any(field.role in ("time", "time_step") for field in recipe.fields)
            rate = None if stamped else recipe.rate
            general = recipe.model_copy(update={"parts": parts, "runs": (), "rate": rate})
            found.setdefault(general.model_dump_json(), (place, general))
    return list(found.values())


def asked(file: Path, options: ImportOptions, sessions: Path | None) -> Recipe:
    """Open the recipe that is proposed for a file in an editor, until the file can be read by it; return it.

    One that was kept in `sessions`, where they are given, is proposed first. Above it stand the columns with their first
    numbers. UsageProblem where the operator empties it, or without a terminal.
    """
    if not sys.stdin.isatty():
        raise UsageProblem(
            "--ask needs a terminal; without one --accept takes what is proposed, and --recipe a file"
        )
    look = look_at(file, options) if sessions is None else look_with_kept(file, sessions, options)[0]
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
