"""Quantisation: the step to which the numbers of a column were rounded when they were written."""

import numpy as np

from daq.recording import Array


def quantum(values: Array) -> float:
    """Return the step of which the numbers are multiples, as they were written; the steps tried are 1, 2, 2.5
    and 5 times a power of ten. One number in a hundred may stray (zeros written as 1e-13); 0 when there are too few.

    Only numbers of the largest decade are looked at: where a file keeps significant digits, these are rounded most.
    """
    finite = np.abs(values[np.isfinite(values)][:20_000])
    top = float(np.max(finite, initial=0.0))
    if len(finite) < 3 or not 1e-200 < top < 1e200:
        return 0.0
    floor = 64.0 * float(np.spacing(top))
    large = finite[finite >= 10.0 ** np.floor(np.log10(top))]
    finite = large if len(large) >= 50 else finite
    exponent = int(np.ceil(np.log10(top)))
    while 10.0**exponent > floor:
        for mantissa in (1.0, 0.5, 0.25, 0.2):
            step = mantissa * 10.0**exponent
            multiples = finite / step
            far = np.abs(multiples - np.rint(multiples)) > 1e-3 + floor / step
            if np.count_nonzero(far) <= len(finite) // 100:
                return step
        exponent -= 1
    return floor
