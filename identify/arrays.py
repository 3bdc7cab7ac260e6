"""Arrays that travel: copied in, double precision, read-only."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def frozen(values: Array | Sequence[float]) -> Array:
    """Return a read-only contiguous float64 copy of `values`."""
    copy = np.array(values, dtype=np.float64)
    copy.setflags(write=False)
    return copy


def frozen_mask(values: Mask | Sequence[bool]) -> Mask:
    """Return a read-only boolean copy of `values`."""
    copy = np.array(values, dtype=np.bool_)
    copy.setflags(write=False)
    return copy
