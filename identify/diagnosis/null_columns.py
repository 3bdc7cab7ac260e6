"""Null columns: what a weak presence of one effect does to the readings, and what of it no parameter of the fit follows.

The effect itself moves all windows; its internal state at the start of one moves that window only, and is not
multiplied with the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from identify.arrays import Array
from identify.fitting.problem import Problem
from identify.fitting.tangent import Tangent

_NONE = 1e-9
"""Norm of a column, in units of the noise, that is none."""


@dataclass(frozen=True, eq=False)
class NullColumns:
    """One column (readings,) of all windows, `whole`, and columns `own` of one window each: which, and (n,) values there."""

    whole: Array | None
    own: tuple[tuple[int, Array], ...]

    @classmethod
    def at(cls, problem: Problem, points: Sequence[Array], before: Array, rows: list[slice]) -> "NullColumns":
        """Return by how much the first of some points moves the misfit `before`, and what the others change of that.

        `rows` are the places of each window's readings; the other points differ from the first in a state at the start
        of one window.
        """
        if not points:
            return cls(None, ())
        first = problem.residuals(points[0])
        own = []
        for point in points[1:]:
            misfit = problem.residuals(point)
            for at in np.flatnonzero(point != points[0]):
                i = problem.unknowns[at].window
                own.append((i, misfit[rows[i]] - first[rows[i]]))
        return cls(
            first - before if _counts(first - before) else None,
            tuple((i, change) for i, change in own if _counts(change)),
        )

    def __len__(self) -> int:
        return len(self.own) + (self.whole is not None)

    def products(self, tangent: Tangent, noise: Array, rows: list[slice]) -> tuple[Array, Array]:
        """Return the products of what is free of the columns, of unit length, with one another and with draws of noise.

        The `tangent` is what the fit's parameters follow, and `noise` (readings, draws) is free of it.
        """
        count, first = len(self), int(self.whole is not None)
        together, along = np.zeros((count, count)), np.zeros((count, noise.shape[1]))
        if self.whole is not None:
            whole = tangent.free(self.whole)
            together[0, 0], along[0] = whole @ whole, whole @ noise
        free = [tangent.beside(i, change) for i, change in self.own]
        for a, (i, _) in enumerate(self.own, first):
            mine, across = free[a - first]
            along[a] = mine @ noise[rows[i]]
            if self.whole is not None:
                together[0, a] = together[a, 0] = whole[rows[i]] @ mine
            for b, (k, _) in enumerate(self.own, first):
                other, other_across = free[b - first]
                together[a, b] = (mine @ other if i == k else 0.0) - across @ other_across
        size = np.sqrt(np.maximum(np.diag(together), 1e-300))
        return together / np.outer(size, size), along / size[:, None]


def _counts(change: Array) -> bool:
    return bool(np.isfinite(change).all() and np.linalg.norm(change) > _NONE)
