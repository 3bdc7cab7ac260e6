"""The even clock behind stamps that do not show it: rounded ones, and rows stamped in blocks."""

import numpy as np
from numpy.typing import NDArray

from daq.recording import Array

Index = NDArray[np.int64]

MARGIN = 1e-6
FEWEST_ROUNDED = 8
CAMERAS = (24000 / 1001, 30000 / 1001, 60000 / 1001)
CLEAR = 0.01  # Hz; three such errors are still far less than the distance between two nominal rates
ROWS_A_BLOCK = 3.0
FEWEST_BLOCKS = 10
NEAR = 1.5
"""Intervals between blocks by which the reading of a block may be late: more is a hole, or no clock at all."""


def rate_within_rounding(index: Array, time: Array, steps: Array) -> tuple[float, float, float] | None:
    """Return period, time of sample 0 and the standard error of the period, by which every stamp is right once it is
    rounded, or cut off, to its step; None when no even clock is.

    `index` (n,), rising, are the samples, `time` (n,) their stamps in s and `steps` (n,) the roundings. All clocks that
    fit form a polygon of period and start: its middle is returned, with the error of a value that is evenly
    spread over the range of periods.
    """
    if len(index) < FEWEST_ROUNDED or not np.all(steps > 0.0):
        return None
    for below, above in ((0.5, 0.5), (0.0, 1.0)):
        slack = MARGIN * steps
        found = _clocks(index, time - below * steps - slack, time + above * steps + slack)
        if found is not None:
            low, high, start = found
            return 0.5 * (low + high), start, (high - low) / np.sqrt(12.0)
    return None


def nominal_rate(rate: float, std: float) -> float | None:
    """Return the rate to which a camera or a logger was set, if one lies within three standard errors of `rate`: a
    whole number of Hz, or a camera's 23.976, 29.97, 59.94 Hz. None where the error is too large to tell.
    """
    nearest = min((float(round(rate)), *CAMERAS), key=lambda known: abs(known - rate))
    return nearest if nearest >= 1.0 and abs(nearest - rate) <= 3.0 * std and std < CLEAR else None


def _clocks(index: Array, low: Array, high: Array) -> tuple[float, float, float] | None:
    """Return the least and the largest period of the lines between `low` and `high`, and the start in their middle."""
    from scipy.optimize import linprog

    ones = np.ones(len(index))
    matrix = np.column_stack([np.r_[-ones, ones], np.r_[-index, index]])
    bound = np.r_[-low, high]
    free = [(None, None), (None, None)]
    ends = []
    for sign in (1.0, -1.0):
        found = linprog([0.0, sign], A_ub=matrix, b_ub=bound, bounds=free)
        if found.status != 0 or found.x is None:
            return None
        ends.append(np.asarray(found.x, dtype=np.float64))
    middle = 0.5 * (ends[0] + ends[1])
    return float(ends[0][1]), float(ends[1][1]), float(middle[0])


def clock_of_blocks(time: Array) -> tuple[float, float, float] | None:
    """Return period, time of sample 0 and the standard error of the rate of rows whose stamps `time` (n,), in s and never
    falling, come in blocks; None when they do not.

    The last row of a block was sampled just before the block was read. The line through these rows is the clock; how
    far blocks stray from it gives its error.
    """
    last = np.flatnonzero(np.diff(time, append=np.inf) > 0.0)
    if len(last) < FEWEST_BLOCKS or len(time) < ROWS_A_BLOCK * len(last):
        return None
    at, stamp = last[:-1], time[last[:-1]]  # the last block may be cut off
    k, t = at - at.mean(), stamp - stamp.mean()
    spread = float(k @ k)
    period = float(k @ t) / spread
    stray = t - period * k
    interval = float(np.median(np.diff(stamp)))
    if not period > 0.0 or float(np.max(np.abs(stray))) > NEAR * interval:
        return None
    error = float(np.sqrt(stray @ stray / max(len(t) - 2, 1) / spread))
    return period, float(stamp.mean() - period * at.mean()), error / period**2
