"""Columns that stand still: a sensor that was connected, beside one that moved."""

from collections.abc import Sequence

import numpy as np

from daq.recording import Array

FEW_VALUES = 12
SMALL, TINY = 0.05, 0.005


def amplitude(values: Array) -> float:
    """Return the standard deviation of the numbers that are there, 0 when there are fewer than two."""
    finite = values[np.isfinite(values)]
    return float(np.std(finite)) if len(finite) > 1 and np.max(np.abs(finite)) < 1e150 else 0.0


def stands_still(values: Array, largest: float) -> bool:
    """Return whether a column stands still beside one whose amplitude is `largest`: its own is below 5 % of that
    and it takes a dozen values at most, or it is below 0.5 %.
    """
    own = amplitude(values)
    if own >= SMALL * largest:
        return False
    return own < TINY * largest or len(np.unique(values[np.isfinite(values)])) <= FEW_VALUES


def moving(columns: Sequence[Array]) -> list[bool]:
    """Return which of several columns of one quantity and unit move."""
    largest = max((amplitude(values) for values in columns), default=0.0)
    return [not stands_still(values, largest) for values in columns]
