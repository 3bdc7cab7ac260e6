"""The common ground of all formats: named columns of numbers, before they are given a meaning."""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from daq.importing.columns import Meaning, meaning
from daq.importing.errors import LONGEST_NAME, problem
from daq.importing.recipe import Dialect, Format, Recipe
from daq.recording import Array


@dataclass(frozen=True, eq=False)
class SourceColumn:
    """One column of a file: what is written above it, and its numbers, NaN where there is none or an infinite one.

    `number` counts from 1; `label` is the header as it stands, cut where it is too long, without a unit row's unit, which
    is in `unit`. `quantity` is set where the format itself says it (UFF). `bad` is the first cell that is
    neither a number nor empty, as (line, text). `clock` is True for dates and times of day (then in s).
    `noun` is what the format calls a column, `arc` the numbers of the columns x and y of which this is the angle.
    """

    number: int
    label: str
    values: Array
    unit: str = ""
    quantity: str | None = None
    bad: tuple[int, str] | None = None
    clock: bool = False
    noun: str = "column"
    arc: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        values = np.asarray(self.values, dtype=np.float64)
        object.__setattr__(self, "values", np.where(np.isfinite(values), values, np.nan))
        object.__setattr__(self, "label", self.label[:LONGEST_NAME])
        object.__setattr__(self, "unit", self.unit[:LONGEST_NAME])

    @property
    def said(self) -> Meaning:
        """What the file says of this column: the format itself, else its header."""
        said = meaning(self.label, self.unit)
        if self.quantity is None:
            return replace(said, quantity="time", strength=2) if self.clock and not said.quantity else said
        unit = said.unit if said.unit is not None and said.unit.quantity in (None, self.quantity) else None
        return Meaning(self.quantity, 3, unit, said.unit_text, said.angular, said.derived, False)

    @property
    def place(self) -> str:
        """How a sentence calls this column."""
        text = " ".join(self.label.split())
        text = text if len(text) <= 40 else text[:37] + "..."
        return f"{self.noun} {self.number} '{text}'" if text else f"{self.noun} {self.number}"


@dataclass(frozen=True, eq=False)
class Table:
    """The columns of one file, or of one run in it, all of one length, with the line each row came from where there
    are lines. `run` is what the file calls the run, "" where it holds one recording. `notes` are what was understood,
    `doubts` what was not, a sentence each; `format`, `encoding` and `dialect` are how it was read, and `stated`
    the units in it.
    """

    path: Path
    columns: tuple[SourceColumn, ...]
    lines: np.ndarray[tuple[int], np.dtype[np.int64]] | None = None
    rate: float | None = None
    rate_source: str = ""
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    run: str = ""
    format: Format = "text"
    encoding: str | None = None
    stated: tuple[str, ...] = ()
    dialect: Dialect = field(default_factory=Dialect)

    def line(self, row: int) -> int | None:
        """Return the 1-based line of a row, or None where the format has no lines."""
        return None if self.lines is None else int(self.lines[row])

    def at(self, row: int) -> str:
        """Return the line of a row in brackets, to stand behind what is there."""
        return "" if self.lines is None else f" (line {self.line(row)})"


def named(table: Table, wanted: str | int, what: str) -> SourceColumn:
    """Return the one column that is called so, for a quantity. Raises ImportProblem where there is none, or several."""
    text = _plain(str(wanted))
    tests = (
        lambda c: c.label == str(wanted),
        lambda c: str(c.number) == str(wanted).strip(),
        lambda c: _plain(c.label) == text != "",
        lambda c: _plain(c.label).split()[:1] == [text],
        lambda c: len(text) > 2 and text in _plain(c.label),
    )
    for test in tests:
        found = [c for c in table.columns if test(c)]
        if len(found) == 1:
            return found[0]
        if found:
            raise problem(
                table.path, f"'{text}' could be {listed(found)}", f"give its number, as {found[0].number}"
            )
    noun = table.columns[0].noun if table.columns else "column"
    raise problem(
        table.path, f"there is no {noun} '{wanted}' for the {what}; the file has {listed(table.columns)}",
        "name one of these, or give its number",
    )  # fmt: skip


def common_length(path: Path, recipe: Recipe, sizes: Sequence[tuple[Sequence[str], int]]) -> int:
    """Return the length of the columns that the recipe names, else the length that most numbers have.

    `sizes` are the names of each column and its length. Raises ImportProblem where those named have several lengths.
    """
    wanted = {(f.name or str(f.column)).casefold() for f in recipe.fields if f.role != "ignored"}
    named = {length for names, length in sizes if wanted & {name.casefold() for name in names}}
    if len(named) > 1:
        raise problem(
            path, f"what was asked for has different lengths ({sorted(named)})", "name columns of one length"
        )
    lengths = Counter(length for _, length in sizes)
    return named.pop() if named else max(lengths, key=lambda n: (n >= 8, n * lengths[n]))


def _plain(name: str) -> str:
    return re.sub(r"[\W_]+", " ", name).strip().casefold()


def listed(columns: Sequence[SourceColumn]) -> str:
    """Return the first columns as a sentence names them."""
    shown = ", ".join(c.place for c in columns[:8])
    return shown + (f" and {len(columns) - 8} more" if len(columns) > 8 else "")
