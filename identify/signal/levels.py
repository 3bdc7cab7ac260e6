"""The levels of a channel: which readings are the same one, and the steps between those that are not.

Two readings that differ by less than `SAME` of the range are one: no converter or simulation is better than that, and
rounding in another unit makes such differences.
"""

import numpy as np

from identify.arrays import Array, Mask

SAME = 1e-9
"""Share of the range of the readings by which two of them may differ by rounding alone."""


def steps_between(values: Array) -> Array:
    """Return the steps between neighbouring levels of readings (n,), one fewer than there are levels, in their unit."""
    if not len(values):
        return values
    steps = np.diff(np.sort(values))
    return np.asarray(steps[steps > SAME * np.ptp(values)])


def stale(readings: Array) -> Mask:
    """Return which readings (n,) repeat the one before, or are zero."""
    rounding = SAME * float(np.ptp(readings))
    mask = np.asarray(np.abs(readings) <= rounding)
    mask[1:] |= np.abs(np.diff(readings)) <= rounding
    return mask
