"""Solvers for banded and bounded systems, without the third of a second that loading `scipy` takes."""

from itertools import combinations, product

import numpy as np

from identify.arrays import Array
from identify.compilation import compiled

_ROUNDING = 1e-12


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


def bounded_least_squares(design: Array, right: Array, low: Array, high: Array) -> Array:
    """Return the x (n,) within `low` and `high` (n,) that makes `design` (m, n) x as near to `right` (m,) as it can be.

    Of all choices of unknowns that are held at a bound it is the one of which none wants to leave its bound inwards
    (Karush, Kuhn and Tucker); those that hold few are tried first.
    """
    ends = [[end for end in pair if np.isfinite(end)] for pair in zip(low, high, strict=True)]
    bounded = [i for i, found in enumerate(ends) if found]
    x = np.clip(np.zeros(len(low)), low, high)
    slack = _ROUNDING * np.linalg.norm(right) * np.linalg.norm(design, axis=0)
    for held in (list(some) for count in range(len(bounded) + 1) for some in combinations(bounded, count)):
        free = [i for i in range(len(low)) if i not in held]
        for values in product(*(ends[i] for i in held)):
            x[held] = values
            left = right - design[:, held] @ x[held]
            x[free] = np.linalg.lstsq(design[:, free], left, rcond=-1)[0]
            inwards = design.T @ (right - design @ x)
            stays = ((x > low) | (inwards <= slack)) & ((x < high) | (inwards >= -slack))
            if np.all((x >= low) & (x <= high)) and np.all(stays[held]):
                return x
    return np.clip(x, low, high)


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
