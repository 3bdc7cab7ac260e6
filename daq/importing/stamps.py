"""The time stamps of a table: their unit, in s from the first, and in an order in which they do not fall."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from daq.importing.errors import ImportProblem, place, problem
from daq.importing.table import SourceColumn, Table
from daq.importing.units import Unit
from daq.plain_text import counted
from daq.recording import Array, Index

USE_RATE = "leave the stamps out by giving the rate with --rate"
FEWEST_IN_A_RUN = 50
DAY = 86400.0


class NoClock(ImportProblem):
    """Stamps that make no clock; `remedy` are the fields of a recipe that would settle it, none where only the operator
    can say it; `done` says what was done where it need not be confirmed.
    """

    def __init__(self, where: str, sentence: str, remedy: Mapping[str, Any], done: str = "") -> None:
        super().__init__(f"{where}: {sentence}")
        self.remedy, self.done = remedy, done


def guess_time_unit(column: SourceColumn) -> tuple[str, str]:
    """Return the unit of stamps that do not say it, and why: seconds, unless whole numbers with long steps say otherwise.

    A free decay is sampled at 5 Hz or faster: whole steps of 1 to 200 are then milliseconds, longer ones
    microseconds, and above a million (of an epoch) nanoseconds.
    """
    finite = column.values[np.isfinite(column.values)]
    steps = np.diff(finite[:100_000])
    steps = np.abs(steps[steps != 0.0])
    step = float(np.median(steps)) if len(steps) else 0.0
    whole = bool(np.all(finite[:1000] == np.round(finite[:1000])))
    if column.clock or not whole or step < 1.0:
        return "s", "seconds were assumed"
    unit, name = (
        ("ms", "milli") if step <= 200.0 else ("us", "micro") if step <= 200_000.0 else ("ns", "nano")
    )
    return unit, f"whole steps of {step:g} were taken for {name}seconds"


def read_stamps(table: Table, column: SourceColumn, unit: Unit, notes: list[str]) -> tuple[Array, Index]:
    """Return the stamps in s from the first one, and the rows that have one."""
    rows = np.flatnonzero(np.isfinite(column.values))
    start = float(column.values[rows[0]]) if len(rows) else 0.0
    stamps = (column.values - start) * unit.scale
    empty = len(stamps) - len(rows)
    if len(rows) < 0.9 * len(stamps):
        raise problem(
            table.path, f"{empty} of {len(stamps)} time stamps are empty", USE_RATE,
            line=table.line(int(np.argmin(np.isfinite(stamps)))) if len(stamps) else None, column=column.number,
        )  # fmt: skip
    if empty:
        notes.append(f"{counted(empty, 'row', 'rows')} without a time stamp left out")
    return _over_midnight(stamps[rows], notes) if column.clock else stamps[rows], rows


def _over_midnight(time: Array, notes: list[str]) -> Array:
    days = np.cumsum(np.diff(time, prepend=time[0]) < -DAY / 2)
    if days[-1]:
        notes.append("the time of day passes midnight; a day was added from there on")
    return time + DAY * days


def in_order(
    table: Table,
    column: SourceColumn,
    time: Array,
    rows: Index,
    values: Array,
    notes: list[str],
    *,
    even: bool,
) -> tuple[Array, Index]:
    """Return stamps that never fall: rows written twice are dropped, rows slightly out of order are sorted.

    Where the newest row comes first, the rows are turned round. A clock that was set back goes on where the rows are said
    to be `even`.
    """
    if time[0] > time[-1] and np.all(np.diff(time) <= 0.0):
        time, rows = time[::-1], rows[::-1]
        notes.append("the newest row comes first: the rows were turned round")
    steps = np.diff(time)
    if np.all(steps > 0.0):
        return time, rows
    back = np.flatnonzero(steps < 0.0)
    typical = float(np.median(np.abs(steps)))
    if len(back):
        depth = float(np.max(np.maximum.accumulate(time) - time))
        if depth > 20.0 * typical or len(back) > len(time) // 20 + 1:
            raise _begins_again(table, column, time, rows)
        order = np.argsort(time, kind="stable")
        if _jumps(time[order]) <= _jumps(time):
            time, rows = time[order], rows[order]
            notes.append(f"{counted(len(back), 'row', 'rows')} out of order: sorted by the time stamps")
        elif even:
            time = time + np.append(0.0, np.cumsum(np.where(steps < 0.0, typical - steps, 0.0)))
        else:
            at = int(back[0]) + 1
            was, now = (f"{column.values[rows[k]]:.15g}" for k in (at - 1, at))
            where = place(table.path, table.line(int(rows[at])), column.number)
            what = f"the clock is set back from {was} to {now}, and the rows go on"
            raise NoClock(where, f"{what}; {USE_RATE}", {"even": True})
    same = np.flatnonzero(np.diff(time) == 0.0) + 1
    if not len(same):
        return time, rows
    here, before = values[:, rows[same]], values[:, rows[same - 1]]
    twice = same[np.all((here == before) | (np.isnan(here) & np.isnan(before)), axis=0)]
    keep = np.ones(len(time), dtype=bool)
    keep[same] = False
    if len(same) <= len(time) // 4 and (len(twice) == len(same) or _stray(time[keep]) < _stray(time)):
        line = table.line(int(rows[same[0]]))
        alike = "" if len(twice) == len(same) else " (with other values)"
        notes.append(
            f"{counted(len(same), 'row repeats', 'rows repeat')} the time stamp of the row before{alike}"
            + (f", first in line {line}" if line else "")
            + "; the repetitions were left out"
        )
        return time[keep], rows[keep]
    notes.append(
        f"{counted(len(same), 'time stamp equals', 'time stamps equal')} the one before: coarser than the sampling"
    )
    return time, rows


def _jumps(time: Array) -> int:
    """Count the steps of a clock that are off the usual one by nearly half of it."""
    steps = np.diff(time)
    usual = float(np.median(steps))
    return int(np.count_nonzero(np.abs(steps - usual) > 0.45 * usual))


def _stray(time: Array) -> float:
    """Return how far stamps stray from an even clock without holes (rms, s)."""
    return even_line(np.arange(len(time)), time)[2]


def even_line(index: Index, time: Array, weight: Array | None = None) -> tuple[float, float, float, float]:
    """Fit an even clock to stamps; return its period, start, rms of the stamps about it, and the standard error of the rate.

    Stamps, and the rms, may have a `weight` (n,) each.
    """
    weight = np.ones(len(time)) if weight is None else weight / np.mean(weight)
    centre, middle = np.average(index, weights=weight), np.average(time, weights=weight)
    k, t = index - centre, time - middle
    spread = float(weight @ k**2)
    slope = float(weight @ (k * t)) / spread
    stray = float(np.sqrt(np.mean(weight * (t - slope * k) ** 2)))
    start = float(middle - slope * centre)
    return slope, start, stray, stray / math.sqrt(spread) / slope**2


def _begins_again(table: Table, column: SourceColumn, time: Array, rows: Index) -> ImportProblem:
    """Return the refusal of stamps that fall: where they always fall to the first one, the rows are runs."""
    back = np.flatnonzero(np.diff(time) < 0.0) + 1
    alike = np.abs(time[back] - time[0]) <= 2.0 * np.median(np.abs(np.diff(time)))
    long = np.diff([0, *back, len(time)]) >= FEWEST_IN_A_RUN
    where = place(table.path, table.line(int(rows[back[0]])), column.number)
    what = f"the time stamp jumps back from {time[back[0] - 1]:.6g} s to {time[back[0]]:.6g} s"
    if alike.all() and long.all():
        done = f"{what}{table.at(rows[back[0]])}: the rows were cut where it does"
        return NoClock(where, what, {"restarts": True}, done)
    todo = (
        "say in a recipe that the rows restart there (restarts = true), or that these are steps (time_step)"
    )
    return ImportProblem(f"{where}: {what}; {todo}; or {USE_RATE}")
