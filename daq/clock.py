"""How fast the samples really come: a straight line through the times at which they were taken or arrived."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class ClockFit:
    """The measured rate in Hz, its standard error, and the span in s over which it was measured."""

    rate: float
    std: float
    span: float


def fit_clock(indices: Sequence[int], times: Sequence[float]) -> ClockFit | None:
    """Return samples per second by least squares over (index, time in s); None with fewer than 8 points.

    The standard error is twice that of independent residuals, because arrivals come in bursts.
    """
    if len(indices) < 8:
        return None
    index = np.asarray(indices, dtype=np.float64)
    time = np.asarray(times, dtype=np.float64)
    span = float(np.ptp(time))
    index = index - index.mean()
    time = time - time.mean()
    square = float(index @ index)
    period = float(index @ time) / square if square else 0.0
    if not np.isfinite(period) or period <= 0:
        return None
    residual = time - period * index
    std = 2 * float(np.sqrt(residual @ residual / (len(index) - 2) / square))
    return ClockFit(1 / period, std / period**2, span)
