"""The even clock behind stamps that were rounded."""

import numpy as np
from numpy.typing import NDArray

from daq.recording import Array

Index = NDArray[np.int64]

MARGIN = 1e-6
FEWEST_ROUNDED = 8


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
