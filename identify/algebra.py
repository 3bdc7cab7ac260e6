"""Solvers for banded systems, without the third of a second that loading `scipy` takes."""

import numpy as np

from identify.arrays import Array
from identify.compilation import compiled


def banded_cholesky(band: Array) -> Array:
    """Return the Cholesky factor L, (w, n), of a symmetric matrix, both in lower banded form; LinAlgError without one."""
    rows = np.array(band.T, dtype=np.float64, order="C")
    if not _factorise(rows):
        raise np.linalg.LinAlgError("the matrix is not positive definite")
    return rows.T


def whiten(factor: Array, values: Array) -> Array:
    """Return L^-1 `values`, of the shape of `values`, (n, ...), for a factor L (w, n) in lower banded form."""
    return _solved(factor, values, back=False)


def solve_factored(factor: Array, values: Array) -> Array:
    """Return (L L')^-1 `values`, (n, ...)."""
    return _solved(factor, values, back=True)


def solve_banded(band: Array, values: Array) -> Array:
    """Return A^-1 `values`, (n, ...), for a symmetric positive definite A (w, n) in lower banded form."""
    return solve_factored(banded_cholesky(band), values)


def recursion(x: Array, keep: float) -> Array:
    """Return y with y[i] = x[i] + keep y[i - 1] along the first axis, y of the shape of x, (n, ...); 0 <= keep < 1."""
    return whiten(np.repeat([[1.0], [-keep]], len(x), axis=1), x)


def _solved(factor: Array, values: Array, *, back: bool) -> Array:
    rows = np.ascontiguousarray(factor.T)
    out = np.array(values, dtype=np.float64, order="C").reshape(len(values), -1)
    _substitute(rows, out, back)
    return out.reshape(values.shape)


@compiled(error_model="numpy")
def _factorise(rows):  # type: ignore[no-untyped-def]
    """Overwrite a lower band, given by its columns (n, w), by its Cholesky factor; False where there is none."""
    n, width = rows.shape
    for j in range(n):
        if not rows[j, 0] > 0.0:
            return False
        rows[j] /= np.sqrt(rows[j, 0])
        reach = min(width, n - j)
        for k in range(1, reach):
            for i in range(k, reach):
                rows[j + k, i - k] -= rows[j, i] * rows[j, k]
    return True


@compiled(error_model="numpy")
def _substitute(rows, x, back):  # type: ignore[no-untyped-def]
    """Overwrite x (n, m) by L^-1 x, with `back` by L'^-1 L^-1 x; L is given by the columns (n, w) of its band."""
    n, width = rows.shape
    for j in range(n):
        for c in range(x.shape[1]):
            x[j, c] /= rows[j, 0]
            for k in range(1, min(width, n - j)):
                x[j + k, c] -= rows[j, k] * x[j, c]
    if back:
        for j in range(n - 1, -1, -1):
            for c in range(x.shape[1]):
                for k in range(1, min(width, n - j)):
                    x[j, c] -= rows[j, k] * x[j + k, c]
                x[j, c] /= rows[j, 0]
