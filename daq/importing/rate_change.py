"""A logger that changed its rate: the row from which its time stamps follow another clock."""

from dataclasses import dataclass

import numpy as np

from daq.importing.quantisation import quantum
from daq.recording import Array

FEWEST = 20
DIFFERENT = 1.2
STRAY = 0.2
"""Share of a sampling interval by which stamps may stray (rms) from a clock; or by no more than their rounding."""


@dataclass(frozen=True)
class RateChange:
    """Rows before `row` come at the rate `before`, those from it on at the rate `after` (Hz)."""

    row: int
    before: float
    after: float


def rate_change(time: Array) -> RateChange | None:
    """Return where stamps `time` (n,), in s and never falling, go over from one even clock to another; None where they
    do not, or where either part is no clock.

    The row is the one at which two lines leave least of the stamps, by least squares.
    """
    count = len(time)
    if count < 2 * FEWEST:
        return None
    index = np.arange(count, dtype=np.float64)
    level = time - np.polyval(np.polyfit(index, time, 1), index)
    left, right = _left_by_a_line(level), _left_by_a_line(level[::-1])[::-1]
    row = FEWEST + int(np.argmin(left[FEWEST - 1 : count - FEWEST] + right[FEWEST : count - FEWEST + 1]))
    rates = [_rate(part) for part in (time[:row], time[row:])]
    before, after = rates
    if before is None or after is None or max(before / after, after / before) < DIFFERENT:
        return None
    return RateChange(row, before, after)


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
