"""Numbers that begin again: an angle after a turn, a counter whose word is full, a sign read as a large number.

A pendulum that hangs at 0 is written as 359, 0, 1; a gyroscope's -3 in two bytes as 65533. Between two rows such a column
jumps by more than half of its range, and counted on it goes on smoothly.
"""

from dataclasses import replace

import numpy as np

from daq.importing.columns import meaning
from daq.importing.options import ImportOptions
from daq.importing.table import SourceColumn, Table
from daq.importing.units import parse_scaled_unit
from daq.recording import Array

WORDS = tuple(2.0**bits for bits in (10, 12, 14, 16, 32))
TURNS = (2.0 * float(np.pi), 360.0)
FEWEST_JUMPS = 2
FEWEST_VALUES = 10
FEWEST_BEYOND = 3
"""Different numbers behind the jumps: a reading that was lost is written as one and the same, 0 or a full word."""

SMOOTH = 0.25
"""Share of the range by which a column counted on may change between two rows: more, and it is not known which way."""


def counted_on(table: Table, options: ImportOptions) -> Table:
    """Return a table whose columns of readings go on where their numbers begin again, with a sentence on each."""
    columns, notes = [], []
    asked = parse_scaled_unit(options.units.get("displacement", ""))
    for column in table.columns:
        readable = column.bad is None and not column.clock
        found = _without_jumps(column, asked is not None and asked.angular) if readable else None
        if found is not None:
            values, step, jumps = found
            what = "a turn" if step in TURNS else f"{step:g}"
            notes.append(
                f"{column.place} jumps by {what} {jumps} times, where its numbers wrap round: the jumps were removed"
            )
            column = replace(column, values=values, wraps=step)
        columns.append(column)
    return replace(table, columns=tuple(columns), notes=(*table.notes, *notes)) if notes else table


def _without_jumps(column: SourceColumn, asked_angle: bool) -> tuple[Array, float, int] | None:
    """Return a column counted on, the range after which its numbers begin again, and how often they do; None if never."""
    there = np.isfinite(column.values)
    values = column.values[there]
    if len(np.unique(values[:1000])) < FEWEST_VALUES:
        return None
    said = meaning(column.label, column.unit)
    angle = said.quantity == "displacement" and said.angular
    angle = angle or (asked_angle and said.quantity in (None, "displacement"))
    whole = bool(np.all(values == np.rint(values)))
    low, high = float(values.min()), float(values.max())
    for step in (*(TURNS if angle else ()), *(WORDS if whole else ())):
        if high > step or low < -0.5 * step or (low < 0.0 and high > 0.5 * step):
            continue
        change = np.diff(values)
        jumps = int(np.count_nonzero(np.abs(change) > 0.5 * step))
        left = change - step * np.rint(change / step)
        if jumps < FEWEST_JUMPS or float(np.max(np.abs(left))) > SMOOTH * step:
            continue
        turns = _turns(values, step)
        usual, counts = np.unique(turns, return_counts=True)
        if len(np.unique(values[turns != usual[np.argmax(counts)]])) < FEWEST_BEYOND:
            continue
        return counted_on_by(column.values, step), step, jumps
    return None


def counted_on_by(values: Array, step: float) -> Array:
    """Return numbers that begin again after `step`, counted on, their median within half a `step` of 0; NaN stay."""
    there = np.isfinite(values)
    on = values[there] - step * _turns(values[there], step)
    made = values.copy()
    made[there] = on - step * np.rint(np.median(on) / step)
    return made


def _turns(values: Array, step: float) -> Array:
    return np.concatenate([[0.0], np.cumsum(np.rint(np.diff(values) / step))])
