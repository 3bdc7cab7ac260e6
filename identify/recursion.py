"""A first-order recursion, without the half second that loading `scipy.signal` costs every program."""

import numpy as np

from identify.arrays import Array
from identify.compilation import compiled


def recursion(x: Array, keep: float) -> Array:
    """Return y with y[i] = x[i] + keep y[i - 1] along the first axis, y of the shape of x, (n, ...); 0 <= keep < 1."""
    columns = np.array(x, dtype=np.float64).reshape(len(x), -1)
    _recur(columns, keep)
    return columns.reshape(x.shape)


@compiled()
def _recur(columns, keep):  # type: ignore[no-untyped-def]
    for i in range(1, columns.shape[0]):
        for j in range(columns.shape[1]):
            columns[i, j] += keep * columns[i - 1, j]
