"""Of several columns that could be one quantity: those that stand still, or only repeat another, are not meant."""

from collections.abc import Mapping, Sequence

import numpy as np

from daq.importing.columns import Meaning, split_unit, words
from daq.importing.errors import ImportProblem
from daq.importing.quantisation import quantum
from daq.importing.still import amplitude, moving
from daq.importing.table import SourceColumn, Table
from daq.importing.timebase import from_stamps, guess_time_unit
from daq.importing.units import SECOND, parse_unit
from daq.recording import Array

TOTALS = frozenset({"absolute", "abs", "total", "norm", "resultant", "modulus", "betrag", "absolut"})
AXES = (frozenset("xyz"), frozenset({"roll", "pitch", "yaw"}), frozenset({"phi", "theta", "psi"}))
"""The names of one point's coordinates, and of one body's angles."""

AXIS_MOVES = 5.0
"""A point moves along an axis if it moves this many times as much as along the others: the rest is 2 % of its path."""

FEWEST = 8


def narrowed(
    columns: Sequence[SourceColumn], said: Mapping[int, Meaning]
) -> tuple[list[SourceColumn], list[str]]:
    """Return those of several columns that could be meant, and a sentence on each reason to leave others out."""
    notes: list[str] = []
    left = _kept(
        columns, [not set(words(c.label)) & TOTALS for c in columns], "{} is the size of a vector", notes
    )
    left = _kept(left, [_varies(c.values) for c in left], "{} is one number throughout", notes)
    left = _kept(left, _moving(left, said), "{} stands still beside the others", notes)
    left = _kept(left, _own(left, said), "{} repeats another column in another unit", notes)
    return left, notes


def clocks(table: Table, columns: Sequence[SourceColumn]) -> tuple[list[SourceColumn], list[str]]:
    """Return the columns that could be a clock: where one alone rises from row to row, or alone makes an even clock."""
    notes: list[str] = []
    left = _kept(columns, [_rises(c.values) for c in columns], "{} does not rise from row to row", notes)
    if len(left) > 1:
        others = [c.values for c in table.columns if c not in columns and c.bad is None]
        beside = np.array(others) if others else np.zeros((1, len(columns[0].values)))
        left = _kept(left, [_makes_a_clock(table, c, beside) for c in left], "{} makes no even clock", notes)
    return left, notes


def _rises(values: Array) -> bool:
    finite = values[np.isfinite(values)]
    return len(finite) > 2 and bool(np.all(np.diff(finite) > 0.0))


def _makes_a_clock(table: Table, column: SourceColumn, values: Array) -> bool:
    try:
        from_stamps(table, column, parse_unit(guess_time_unit(column)[0]) or SECOND, values, resample=False)
    except ImportProblem:
        return False
    return True


def along_one_axis(
    columns: Sequence[SourceColumn], said: Mapping[int, Meaning]
) -> tuple[list[SourceColumn], list[str]]:
    """Return the coordinate that a point moves along, or the angle that a body swings by, and why not the others; all where
    there is no such.
    """
    notes: list[str] = []
    why = "{} moves less than a fifth as much as another axis of the same point"
    return _kept(columns, _along(columns, said), why, notes), notes


def _kept(
    columns: Sequence[SourceColumn], keep: Sequence[bool], why: str, notes: list[str]
) -> list[SourceColumn]:
    kept = [c for c, good in zip(columns, keep, strict=True) if good]
    if not kept:
        return list(columns)
    notes += [why.format(c.place) + ": left out" for c, good in zip(columns, keep, strict=True) if not good]
    return kept


def _varies(values: Array) -> bool:
    finite = values[np.isfinite(values)]
    return len(finite) > 0 and bool(np.any(finite != finite[0]))


def _moving(columns: Sequence[SourceColumn], said: Mapping[int, Meaning]) -> list[bool]:
    """Compare the channels of one kind: of the same name but for a number or a letter, in the same unit."""
    kinds = [(_kind(c), said[c.number].unit_text) for c in columns]
    keep: dict[int, bool] = {}
    for kind in set(kinds):
        alike = [c for c, own in zip(columns, kinds, strict=True) if own == kind]
        keep |= dict(zip((c.number for c in alike), moving([c.values for c in alike]), strict=True))
    return [keep[c.number] for c in columns]


def _along(columns: Sequence[SourceColumn], said: Mapping[int, Meaning]) -> list[bool]:
    """Return which of the coordinates of one point, or angles of one body, in one unit, moves far the most; all else."""
    names = [split_unit(c.label)[0].strip().lower() for c in columns]
    units = {said[c.number].unit_text for c in columns}
    sizes = [amplitude(c.values) for c in columns]
    of_one = any(set(names) <= axes for axes in AXES)
    alike = len(set(names)) == len(names) > 1 and of_one and len(units) == 1
    if not alike or sorted(sizes)[-1] < AXIS_MOVES * sorted(sizes)[-2]:
        return [True] * len(columns)
    return [size == max(sizes) for size in sizes]


def _kind(column: SourceColumn) -> tuple[str, ...]:
    bare = [word.rstrip("0123456789") for word in words(split_unit(column.label)[0])]
    return tuple(w for w in bare if len(w) > 1) or tuple(w for w in bare if w)


def _own(columns: Sequence[SourceColumn], said: Mapping[int, Meaning]) -> list[bool]:
    """Return which columns are not, to within the rounding of their numbers, another of another unit times a constant: of
    a length and an angle the length is the one that repeats, of others the later one.
    """

    def repeats(k: int, other: int) -> bool:
        one, two = said[columns[k].number], said[columns[other].number]
        second = one.angular < two.angular or (one.angular == two.angular and other < k)
        another = one.unit_text != two.unit_text and k != other and second
        return another and _repeats(columns[k].values, columns[other].values)

    return [not any(repeats(k, other) for other in range(len(columns))) for k in range(len(columns))]


def _repeats(values: Array, other: Array) -> bool:
    there = np.isfinite(values) & np.isfinite(other)
    if np.count_nonzero(there) < FEWEST or np.count_nonzero(there) < 0.9 * np.count_nonzero(
        np.isfinite(values)
    ):
        return False
    y, x = values[there], other[there]
    power = float(x @ x) if np.max(np.abs(x)) < 1e100 and np.max(np.abs(y)) < 1e100 else 0.0
    if power == 0.0 or np.ptp(x) == 0.0:
        return False
    factor = float(x @ y) / power
    rounding = 0.5 * (_step(y) + abs(factor) * _step(x))
    return factor != 0.0 and bool(np.mean(np.abs(y - factor * x) <= 1.1 * rounding) > 0.98)


def _step(values: Array) -> float:
    """Return the step of the large numbers: some programs write small ones with more decimals."""
    return quantum(values[np.abs(values) >= 0.05 * np.max(np.abs(values))])
