"""Reversals: where dry friction makes the acceleration jump between two samples, and what that does to sums of samples.

The mean of the acceleration over an interval depends on where in it the jump fell. A jump at which the velocity
changes sign is taken to have fallen where the velocity is zero, which both channels tell within microseconds.
"""

import numpy as np

from identify.arrays import Array
from identify.signal.kinematics import AVERAGES


def reversal_excess(high: Array, velocity: Array, noise: float, order: int) -> Array:
    """Return the excess (n,) of the averages N `high` over the true means, for jumps at the zeros of `velocity`.

    `high` and `velocity` have shape (n,) and one clock; `noise` is the standard deviation of `high`; `order` is that of the
    pair. A unit jump a share s of the way from sample i to i + 1 has, in rows i and i + 1, the true
    means (1 - s)^2 / 2 and 1 - s^2 / 2 of a second difference, and 1 - s in row i of a first difference.
    """
    n = len(high)
    excess = np.zeros(n)
    steps = np.diff(high)
    jump = np.zeros(n - 1)
    jump[1:-1] = steps[1:-1] - 0.5 * (steps[:-2] + steps[2:])
    crossing = velocity[:-1] * velocity[1:] <= 0.0
    size = np.abs(jump)
    peak = np.zeros(n - 1, dtype=bool)
    peak[1:-1] = (size[1:-1] >= size[:-2]) & (size[1:-1] >= size[2:])
    found = np.flatnonzero(peak & (size > 6.0 * noise))
    first, taps = AVERAGES[order]
    sampled = np.cumsum(taps[::-1])
    for i in found:
        place = next((k for k in (i, i - 1, i + 1) if 0 <= k < n - 1 and crossing[k]), None)
        if place is None or i < 4 or i > n - 6:
            continue
        share = (
            velocity[place] / (velocity[place] - velocity[place + 1])
            if velocity[place] != velocity[place + 1]
            else 0.5
        )
        share = float(np.clip(share + place - i, 0.0, 1.0))
        rows = np.arange(len(taps)) + i + 2 - first - len(taps)
        true = (rows > i).astype(float)
        if order == 2:
            true[rows == i] = 0.5 * (1.0 - share) ** 2
            true[rows == i + 1] = 1.0 - 0.5 * share**2
        else:
            true[rows == i] = 1.0 - share
        excess[rows] += jump[i] * (sampled - true)
    return excess
