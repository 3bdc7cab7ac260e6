"""Angles without a unit: degrees, where they swing by more than half a turn otherwise; or an encoder's counts."""

from collections.abc import Sequence

import numpy as np

from daq.importing.columns import meaning
from daq.importing.table import SourceColumn, Table

TURN = 2.0 * float(np.pi)
MOST_DEGREES = 720.0
"""No rig swings by more than two turns to either side: numbers beyond are an encoder's counts."""


def units_of_angles(tables: Sequence[Table]) -> dict[str, str]:
    """Return the unit of angles that name none by their labels, one for all runs of a file: deg or counts where one run
    swings by more than half a turn in rad to either side, since few rigs do; others are in rad.
    """
    swings: dict[str, float] = {}
    for column in (c for table in tables for c in table.columns if _is_bare(c)):
        swings[column.label] = max(swings.get(column.label, 0.0), _swing(column))
    return {k: "deg" if far <= MOST_DEGREES else "counts" for k, far in swings.items() if far > 0.5 * TURN}


def _is_bare(column: SourceColumn) -> bool:
    said = meaning(column.label, column.unit)
    return said.quantity == "displacement" and said.angular and said.unit is None and column.bad is None


def _swing(column: SourceColumn) -> float:
    finite = column.values[np.isfinite(column.values)]
    if len(finite) < 2 or not np.max(np.abs(finite)) < 1e100:
        return 0.0
    if np.max(np.abs(np.diff(finite))) > 0.9 * TURN and np.max(np.abs(finite)) < 1.1 * TURN:
        return 0.0  # jumps by a turn: radians
    return float(np.percentile(np.abs(finite - np.median(finite)), 99.5))
