"""Angles without a unit: degrees, where they swing by more than half a turn otherwise."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from daq.importing.columns import meaning
from daq.importing.options import ImportOptions
from daq.importing.table import SourceColumn, Table

HALF_TURN = float(np.pi)
TURN = 2.0 * HALF_TURN
MOST_DEGREES = 720.0
"""No rig swings by more than two turns to either side: numbers beyond are an encoder's counts."""


def agreed(tables: Sequence[Table], options: ImportOptions) -> list[Table]:
    """Return the runs of a file with the unit of angles that have none: degrees in all of them if any run swings by
    more than 3.1 to either side, since few rigs turn by more than half a turn.
    """
    if "displacement" in options.units:
        return (
            _with(tables, {"velocity": "deg/s"})
            if options.units["displacement"] in ("deg", "°")
            else list(tables)
        )
    swings: dict[str, float] = {}
    for column in (c for t in tables for c in t.columns if _is_bare(c, "displacement")):
        swings[column.label] = max(swings.get(column.label, 0.0), _swing(column))
    wide = {label: swing for label, swing in swings.items() if swing > HALF_TURN}
    if not wide:
        return list(tables)
    far = max(wide.values())
    unit, name = ("counts", "counts") if far > MOST_DEGREES else ("deg", "degrees")
    note = (
        f"the angle {', '.join(wide)} swings to {far:.3g} and names no unit: {name} were assumed "
        "(change it with --unit displacement=rad)"
    )
    others = {} if unit == "counts" else {"velocity": "deg/s", "acceleration": "deg/s^2"}
    marked = _with(tables, {"displacement": unit} | others, [label for label in swings if label not in wide])
    return [replace(t, notes=(*t.notes, note)) for t in marked]


def _with(tables: Sequence[Table], units: Mapping[str, str], but: Sequence[str] = ()) -> list[Table]:
    def marked(column: SourceColumn) -> SourceColumn:
        unit = (
            next((u for q, u in units.items() if _is_bare(column, q)), "") if column.label not in but else ""
        )
        return replace(column, unit=unit) if unit else column

    return [replace(t, columns=tuple(marked(c) for c in t.columns)) for t in tables]


def _is_bare(column: SourceColumn, quantity: str) -> bool:
    said = meaning(column.label, column.unit)
    return said.quantity == quantity and said.angular and said.unit is None and column.bad is None


def _swing(column: SourceColumn) -> float:
    finite = column.values[np.isfinite(column.values)]
    if len(finite) < 2 or not np.max(np.abs(finite)) < 1e100:
        return 0.0
    if np.max(np.abs(np.diff(finite))) > 0.9 * TURN and np.max(np.abs(finite)) < 1.1 * TURN:
        return 0.0  # jumps by a turn: radians
    return float(np.percentile(np.abs(finite - np.median(finite)), 99.5))
