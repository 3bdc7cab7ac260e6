"""Angles that begin again after a turn: a pendulum that hangs at 0 is written as 359, 0, 1.

Between two rows such a column jumps by nearly a turn, and counted on it goes on smoothly. Of a counter whose word is full a
recipe says so (`wraps`), and the check of the readings sees it.
"""

from dataclasses import replace

import numpy as np

from daq.importing.columns import meaning
from daq.importing.options import ImportOptions
from daq.importing.table import SourceColumn, Table
from daq.importing.units import parse_scaled_unit
from daq.recording import Array

TURNS = (2.0 * float(np.pi), 360.0)
FEWEST_JUMPS = 2
SMOOTH = 0.25
"""Share of a turn by which an angle counted on may change between two rows: more, and it is not known which way."""


def counted_on(table: Table, options: ImportOptions) -> Table:
    """Return a table whose angles go on where their numbers begin again, with a sentence on each."""
    columns, notes = [], []
    asked = parse_scaled_unit(options.units.get("displacement", ""))
    for column in table.columns:
        said = meaning(column.label, column.unit)
        angle = said.quantity == "displacement" and said.angular
        angle = angle or (asked is not None and asked.angular and said.quantity in (None, "displacement"))
        turn, jumps = _turn(column) if angle and column.bad is None and not column.clock else (None, 0)
        if turn is not None:
            notes.append(f"{column.place} jumps by a turn {jumps} times: the jumps were removed")
            column = replace(column, values=counted_on_by(column.values, turn), wraps=turn)
        columns.append(column)
    return replace(table, columns=tuple(columns), notes=(*table.notes, *notes)) if notes else table


def _turn(column: SourceColumn) -> tuple[float | None, int]:
    """Return the turn after which an angle begins again, None if it does not, and how often it does."""
    values = column.values[np.isfinite(column.values)]
    for turn in TURNS if len(values) else ():
        low, high = float(values.min()), float(values.max())
        inside = high <= turn and low >= -0.5 * turn and (low >= 0.0 or high <= 0.5 * turn)
        change = np.diff(values)
        jumps = int(np.count_nonzero(np.abs(change) > 0.5 * turn))
        left = np.abs(change - turn * np.rint(change / turn))
        if inside and jumps >= FEWEST_JUMPS and float(left.max()) <= SMOOTH * turn:
            return turn, jumps
    return None, 0


def counted_on_by(values: Array, step: float) -> Array:
    """Return numbers that begin again after `step`, counted on, their median within half a `step` of 0; NaN stay."""
    there = np.isfinite(values)
    on = np.unwrap(values[there], period=step)
    made = values.copy()
    made[there] = on - step * np.rint(np.median(on) / step)
    return made
