"""Stamps of which only a part follows one even clock: the logger changed its rate, or lost its place."""

import numpy as np

from daq.importing.quantisation import quantum
from daq.recording import Array

FEWEST = 20
STRAY = 0.2
"""Share of a sampling interval by which stamps may stray (rms) from a clock; or by no more than their rounding."""


def even_part(time: Array) -> tuple[int, int, tuple[float, float]] | None:
    """Return the larger part of stamps `time` (n,), in s and never falling, that follows one clock, as (first row, one past
    its last), and the rates (Hz) before and after the other part; None where either part is no clock.

    The parts meet at the row at which two lines leave least of the stamps, by least squares.
    """
    count = len(time)
    if count < 2 * FEWEST:
        return None
    index = np.arange(count, dtype=np.float64)
    level = time - np.polyval(np.polyfit(index, time, 1), index)
    left, right = _left_by_a_line(level), _left_by_a_line(level[::-1])[::-1]
    row = FEWEST + int(np.argmin(left[FEWEST - 1 : count - FEWEST] + right[FEWEST : count - FEWEST + 1]))
    before, after = _rate(time[:row]), _rate(time[row:])
    if before is None or after is None:
        return None
    return (0, row, (before, after)) if 2 * row >= count else (row, count, (before, after))


def _left_by_a_line(values: Array) -> Array:
    """Return the sum of squares that the best line leaves of the first 1, 2, ... values, (n,)."""
    count = np.arange(1.0, len(values) + 1.0)
    index = count - 1.0
    x, y = np.cumsum(index), np.cumsum(values)
    xx, xy, yy = np.cumsum(index**2), np.cumsum(index * values), np.cumsum(values**2)
    spread = np.maximum(xx - x**2 / count, 1e-300)
    return np.maximum(yy - y**2 / count - (xy - x * y / count) ** 2 / spread, 0.0)


def _rate(time: Array) -> float | None:
    """Return the rate (Hz) of stamps that follow a clock, else None."""
    index = np.arange(len(time), dtype=np.float64)
    slope, start = np.polyfit(index, time, 1)
    apart = np.abs(time - start - slope * index)
    even = float(np.sqrt(np.mean(apart**2))) <= STRAY * slope or float(np.max(apart)) < 1.1 * quantum(time)
    return float(1.0 / slope) if slope > 0.0 and even else None
