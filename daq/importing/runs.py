"""Several releases side by side in one table: the columns of each, told by their names."""

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TypeVar

import numpy as np

from daq.importing.columns import RUN_AND_NUMBER, split_unit, words
from daq.importing.errors import ImportProblem
from daq.importing.options import ImportOptions
from daq.importing.table import SourceColumn, Table
from daq.recording import Index

T = TypeVar("T")
Made = TypeVar("Made")
Named = tuple[str, str]
FEWEST_ROWS = 8
MOST_RUNS = 1000
_STRUCTURE = re.compile(r".*\((\d{1,4})\)\.(.+)")
_BY_NUMBER = re.compile(r"(.*[^\d\W_])[\s._#-]*(\d{1,3})")
_COPY = re.compile(r"(.*\S)\.\d{1,3}")


def find_runs(table: Table, options: ImportOptions) -> list[Table]:
    """Return the table of each run, in the order of the file, or the table itself when it holds one recording.

    Runs are found by a word and a number in the names (`Angle (rad) Run #3`), by the members of a structure array, by
    numbers at the end of names (`t1 theta1 t2 theta2`), or by names that repeat. Each has a time of its own, or all share
    one or have none (for bare numbers only where the operator asks for a run: `x1` and `x2` may be two masses).
    """
    shared = options.run is not None
    found = (
        _by_names(table, _word, shared=True) or _by_names(table, _number, shared=shared) or _by_times(table)
    )
    return found or [table]


def _word(column: SourceColumn) -> Named | None:
    structure = _STRUCTURE.fullmatch(column.label)
    if structure is not None:
        return structure[2], structure[1]
    match = RUN_AND_NUMBER.search(column.label)
    if match is None:
        return None
    rest = f"{column.label[: match.start()]} {column.label[match.end() :]}".strip(" ,:;_-")
    return rest, match[1]


def _number(column: SourceColumn) -> Named | None:
    name, unit, _ = split_unit(column.label)
    match = _BY_NUMBER.fullmatch(name)
    if match is None:
        return None
    return (f"{match[1].strip()} ({unit})" if unit else match[1].strip()), match[2].lstrip("0") or "0"


def _by_names(table: Table, name_of: Callable[[SourceColumn], Named | None], *, shared: bool) -> list[Table]:
    groups: dict[str, list[SourceColumn]] = {}
    rest = []
    for column in table.columns:
        named = name_of(column)
        if named is None:
            rest.append(column)
        else:
            groups.setdefault(named[1], []).append(replace(column, label=named[0]))
    times = [c for c in rest if _is_time(c)]
    if times and (not shared or any(_is_time(c) for columns in groups.values() for c in columns)):
        return []
    return _accepted(table, groups, times, timeless=shared)


def _by_times(table: Table) -> list[Table]:
    """Cut a table at columns of time under one name, where what follows repeats its names.

    The name need not be known as that of a time: nothing else rises evenly in each of several runs.
    """
    named = [c for c in table.columns if c.bad is not None or np.isfinite(c.values).any()]
    named = [replace(c, label=_COPY.sub(r"\1", c.label)) for c in named]
    names = [f"{' '.join(words(c.label)) or c.label} {c.unit}" for c in named]
    places = [i for i, c in enumerate(named) if names[i] == names[0] and (_is_time(c) or rises_evenly(c))]
    parts = [named[a:b] for a, b in pairwise([*places, len(named)])]
    if len(parts) < 2 or places[0] or len({len(part) for part in parts}) > 1:
        return []
    if len({tuple(names[i : i + len(parts[0])]) for i in places}) > 1:
        return []
    groups = {str(k): [replace(c[0], quantity="time"), *c[1:]] for k, c in enumerate(parts, start=1)}
    return _accepted(table, groups, [])


def rises_evenly(column: SourceColumn) -> bool:
    """Check whether the numbers that are there rise to the end in steps that are nearly alike; rounded ones may stand."""
    values = column.values[np.isfinite(column.values)]
    if column.bad is not None or len(values) < FEWEST_ROWS or not np.max(np.abs(values)) < 1e100:
        return False
    steps = np.diff(values)
    return bool(np.all(steps >= 0.0) and 0.0 < np.max(steps) < 20.0 * np.mean(steps))


def of_each(runs: Iterable[T], make: Callable[[T], Made]) -> tuple[list[Made], tuple[str, ...]]:
    """Return what is made of each run, and a sentence for each that is left out. ImportProblem when nothing is made."""
    made: list[Made] = []
    refused: list[ImportProblem] = []
    for run in runs:
        try:
            made.append(make(run))
        except ImportProblem as refusal:
            refused.append(refusal)
    if not made:
        raise refused[0]
    return made, tuple(f"a run was left out: {refusal}" for refusal in refused)


def pieces(table: Table, columns: Sequence[SourceColumn], by: SourceColumn, *, counted: bool) -> list[Table]:
    """Return the runs that stand below one another: where the column `by` that counts them changes, or as a time falls."""
    steps = np.diff(by.values)
    edges = (np.flatnonzero(steps != 0.0 if counted else steps < 0.0) + 1).tolist()
    edges = edges[: MOST_RUNS + 1]
    found = list(pairwise([0, *edges, len(by.values)]))
    names = [f"{by.values[a]:.6g}" if counted else str(k) for k, (a, _) in enumerate(found, start=1)]
    return [part_of(table, name, columns, np.arange(a, b)) for name, (a, b) in zip(names, found, strict=True)]


def _accepted(
    table: Table, groups: dict[str, list[SourceColumn]], shared: list[SourceColumn], *, timeless: bool = False
) -> list[Table]:
    """Return the runs if there are several, and each has something beside its one time; `timeless` ones may have none."""
    parts = []
    for run, columns in groups.items():
        own = [c for c in columns if _is_time(c)]
        rising = [c for c in columns if rises_evenly(c)] if not own and not shared else []
        if len(rising) == 1:
            own = [replace(rising[0], quantity="time")]
            columns = [own[0] if c is rising[0] else c for c in columns]
        times = own or shared
        if len(times) > 1 or (not times and not timeless) or len(columns) == len(own):
            return []
        kept = [*times, *(c for c in columns if c not in times)]
        kept = [c for c in kept if c.bad is not None or np.isfinite(c.values).any()]
        rows = rows_of(kept, times)
        if len(rows) >= FEWEST_ROWS:
            parts.append(part_of(table, run, kept, rows))
    return parts if len(groups) > 1 else []


def _is_time(column: SourceColumn) -> bool:
    return column.clock or column.said.quantity == "time"


def rows_of(columns: Sequence[SourceColumn], times: Sequence[SourceColumn]) -> Index:
    """Return the rows from the first to the last in which a run has its time and something beside it."""
    beside = [np.isfinite(c.values) for c in columns if c not in times]
    there = np.all([np.any(beside, axis=0), *(np.isfinite(c.values) for c in times)], axis=0)
    rows = np.flatnonzero(there)
    return np.arange(rows[0], rows[-1] + 1) if len(rows) else rows


def part_of(table: Table, run: str, columns: Sequence[SourceColumn], rows: Index) -> Table:
    """Return some columns and rows of a table as those of a run."""
    cut_columns = tuple(replace(c, values=c.values[rows]) for c in columns)
    lines = None if table.lines is None else table.lines[rows]
    return replace(table, columns=cut_columns, lines=lines, run=run)
