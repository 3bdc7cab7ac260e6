"""Numbers that begin again: an angle after a turn (359, 0, 1), a counter whose word is full (65535, 0, 1).

Between two rows such a column jumps by nearly as much; counted on, it goes on smoothly. A recipe names other ranges
(`wraps`).
"""

from dataclasses import replace

import numpy as np

from daq.importing.columns import meaning
from daq.importing.options import ImportOptions
from daq.importing.table import SourceColumn, Table
from daq.importing.units import parse_scaled_unit
from daq.recording import Array

TURNS = (2.0 * float(np.pi), 360.0)
WORDS = (2.0**16, 2.0**32)
FEWEST_JUMPS = 2
FEWEST_BEYOND = 3
"""Different numbers behind the jumps: a reading that was lost is written as one and the same, 0 or a full word."""

SMOOTH = 0.25
"""Share of the range by which a column counted on may change between two rows: more, and it is not known which way."""


def counted_on(table: Table, options: ImportOptions) -> Table:
    """Return a table whose columns go on where their numbers begin again, with a sentence on each."""
    columns, notes = [], []
    asked = parse_scaled_unit(options.units.get("displacement", ""))
    for column in table.columns:
        said = meaning(column.label, column.unit)
        angle = said.quantity == "displacement" and said.angular
        angle = angle or (asked is not None and asked.angular and said.quantity in (None, "displacement"))
        readable = column.bad is None and not column.clock
        step, jumps = _range(column, angle=angle) if readable else (None, 0)
        if step is not None:
            what = "a turn" if step in TURNS else f"{step:.0f}"
            notes.append(f"{column.place} jumps by {what} {jumps} times: the jumps were removed")
            column = replace(column, values=counted_on_by(column.values, step), wraps=step)
        columns.append(column)
    return replace(table, columns=tuple(columns), notes=(*table.notes, *notes)) if notes else table


def _range(column: SourceColumn, *, angle: bool) -> tuple[float | None, int]:
    """Return the range after which numbers begin again, None if they do not, and how often they do."""
    values = column.values[np.isfinite(column.values)]
    whole = bool(np.all(values == np.rint(values)))
    for step in (*(TURNS if angle else ()), *(WORDS if whole else ())) if len(values) else ():
        low, high = float(values.min()), float(values.max())
        inside = high <= step and low >= -0.5 * step and (low >= 0.0 or high <= 0.5 * step)
        turns = np.cumsum(np.rint(np.diff(values, prepend=values[:1]) / step))
        jumps = int(np.count_nonzero(np.diff(turns)))
        left = np.abs(np.diff(values - step * turns))
        beyond = np.unique(values[turns != np.median(turns)])
        smooth = bool(len(left)) and float(left.max()) <= SMOOTH * step
        if inside and smooth and jumps >= FEWEST_JUMPS and len(beyond) >= FEWEST_BEYOND:
            return step, jumps
    return None, 0


def counted_on_by(values: Array, step: float) -> Array:
    """Return numbers that begin again after `step`, counted on, their median within half a `step` of 0; NaN stay."""
    there = np.isfinite(values)
    on = np.unwrap(values[there], period=step)
    made = values.copy()
    made[there] = on - step * np.rint(np.median(on) / step)
    return made
