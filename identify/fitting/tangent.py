"""The tangent: all changes of the readings that a fit's own parameters can follow, to first order.

An orthonormal basis of them, in two parts: directions that move one window only, and those of the shared physics, which
move all, less what the former follow of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from identify.arrays import Array


@dataclass(frozen=True, eq=False)
class Tangent:
    """An orthonormal basis: `own[i]` (n, k) moves window i only, `shared[i]` (n, s) are rows of those of all."""

    own: tuple[Array, ...]
    shared: tuple[Array, ...]

    @classmethod
    def of(cls, own: Sequence[Array], common: Sequence[Array] | None) -> Self:
        """Return the basis of the rows of `own` (k, n), one a window, and of `common` (s, n), one a window, if any."""
        first = tuple(_orthonormal(rows.T) for rows in own)
        if common is None:
            return cls(first, tuple(np.zeros((len(basis), 0)) for basis in first))
        size = np.sqrt(np.sum([np.sum(rows**2, axis=1) for rows in common], axis=0))
        size = np.where(size > 0.0, size, 1.0)
        left = []
        for basis, rows in zip(first, common, strict=True):
            columns = rows.T / size
            left.append(columns - basis @ (basis.T @ columns))
        together = _orthonormal(np.concatenate(left))
        ends = np.cumsum([len(basis) for basis in first])[:-1]
        return cls(first, tuple(np.split(together, ends)))

    def part(self, i: int) -> Array:
        """Return the rows of window i of all directions that move it, (n, k + s)."""
        return np.concatenate([self.own[i], self.shared[i]], axis=1)

    def free(self, columns: Array) -> Array:
        """Return what the parameters cannot follow of some columns (readings, m) or of one (readings,)."""
        parts = [
            part - basis @ (basis.T @ part)
            for basis, part in zip(self.own, self._split(columns), strict=True)
        ]
        if self.shared[0].shape[1]:
            common = np.sum([basis.T @ part for basis, part in zip(self.shared, parts, strict=True)], axis=0)
            for part, basis in zip(parts, self.shared, strict=True):
                part -= basis @ common
        return np.concatenate(parts)

    def beside(self, i: int, column: Array) -> tuple[Array, Array]:
        """Return a column (n,) that moves window i only, less what its own parameters follow, and what of it lies elsewhere.

        The latter are its products with the directions of all windows, (s,).
        """
        free = column - self.own[i] @ (self.own[i].T @ column)
        return free, self.shared[i].T @ free

    def _split(self, columns: Array) -> list[Array]:
        return np.split(columns, np.cumsum([len(basis) for basis in self.own])[:-1])


def _orthonormal(columns: Array) -> Array:
    """Return an orthonormal basis of columns (n, k), (n, k)."""
    size = np.linalg.norm(columns, axis=0)
    return np.asarray(np.linalg.qr(columns / np.where(size > 0.0, size, 1.0))[0])
