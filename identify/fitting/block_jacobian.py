"""The Jacobian in blocks: for each window only the unknowns that change it.

Windows share the physics, and each has a start, lag, gain and offsets of its own, which move no other window. What one
release has of its own moves its windows, and a last block besides: where it is expected. All other entries are zero; they
are not stored, not multiplied, and not changed by an update after a step.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Self

import numpy as np
from numpy.typing import NDArray

from identify.arrays import Array, Mask

_STOOD_STILL = 1e-12
"""Share of a step's square that lies in a window below which it was not moved."""


@dataclass(frozen=True, eq=False)
class BlockPattern:
    """Which unknowns move which windows: `places[i]` are those of window i, `shared` (unknowns,) marks those of several.

    `found[j]` lists the windows that unknown j moves, each with its place among that window's own.
    """

    places: tuple[NDArray[np.int_], ...]
    shared: Mask
    found: tuple[tuple[tuple[int, int], ...], ...]

    @classmethod
    def of(cls, moves: Sequence[Sequence[int] | None], windows: int, expected: Sequence[int] = ()) -> Self:
        """Return the pattern of unknowns each of which `moves` some of so many windows (None: all).

        Those that are `expected` somewhere move a block behind those of the windows too.
        """
        every = range(windows)
        blocks = [tuple(every) if own is None else (*own,) for own in moves]
        for j in expected:
            blocks[j] = (*blocks[j], windows)
        count = windows + bool(expected)
        places = tuple(
            np.array([j for j, own in enumerate(blocks) if i in own], dtype=int) for i in range(count)
        )
        found: list[list[tuple[int, int]]] = [[] for _ in moves]
        for i, at in enumerate(places):
            for row, j in enumerate(at.tolist()):
                found[j].append((i, row))
        shared = np.array([own is None or len(blocks[j]) > 1 for j, own in enumerate(moves)], dtype=bool)
        return cls(places, shared, tuple(tuple(one) for one in found))


@dataclass(frozen=True, eq=False)
class BlockJacobian:
    """How the misfit of each window changes with its unknowns: `blocks[i]` (own, n) has a row for each of its places."""

    pattern: BlockPattern
    blocks: tuple[Array, ...]

    @classmethod
    def zeros(cls, pattern: BlockPattern, readings: Sequence[int]) -> Self:
        """Return one of zeros, for so many readings a window."""
        return cls(
            pattern, tuple(np.zeros((len(at), n)) for at, n in zip(pattern.places, readings, strict=True))
        )

    def __len__(self) -> int:
        """Return the number of readings in all windows."""
        return sum(block.shape[1] for block in self.blocks)

    @property
    def rows(self) -> list[slice]:
        """Where the readings of each window stand among all."""
        ends = np.cumsum([0, *(block.shape[1] for block in self.blocks)]).tolist()
        return [slice(a, b) for a, b in pairwise(ends)]

    def of_unknown(self, j: int) -> Iterator[tuple[int, Array]]:
        """Yield each window that unknown j moves with its row there, (n,), which may be written to."""
        for i, row in self.pattern.found[j]:
            yield i, self.blocks[i][row]

    def change(self, step: Array) -> Array:
        """Return the change of the misfit by a small step of the unknowns, (readings,)."""
        return np.concatenate(
            [step[at] @ block for at, block in zip(self.pattern.places, self.blocks, strict=True)]
        )

    def gradient(self, misfit: Array) -> Array:
        """Return the products of all columns with a misfit (readings,), (unknowns,)."""
        total = np.zeros(len(self.pattern.shared))
        for at, block, rows in zip(self.pattern.places, self.blocks, self.rows, strict=True):
            total[at] += block @ misfit[rows]
        return total

    def normal(self) -> Array:
        """Return the products of all columns with one another, (unknowns, unknowns)."""
        total = np.zeros((len(self.pattern.shared), len(self.pattern.shared)))
        for at, block in zip(self.pattern.places, self.blocks, strict=True):
            total[np.ix_(at, at)] += block @ block.T
        return total

    def mended(self, step: Array, size: Array, surprise: Array) -> Self:
        """Update the Jacobian (Broyden) to agree with a step whose misfit differed by `surprise` from the prediction.

        `size` (unknowns,) is the unit of each unknown. Entries that are zero by nature stay zero (Broyden, 1965,
        eq. 4.5, in each window with its own unknowns: Schubert, Math. Comp. 24, 1970). A window that a step has hardly
        moved teaches nothing but rounding.
        """
        blocks, largest = [], float(np.sum((step / size) ** 2))
        for at, block, rows in zip(self.pattern.places, self.blocks, self.rows, strict=True):
            moved = step[at] / size[at]
            square = float(moved @ moved)
            if square > _STOOD_STILL * largest:
                block = block + np.outer(moved / size[at] / square, surprise[rows])
            blocks.append(block)
        return type(self)(self.pattern, tuple(blocks))

    def free(self, columns: Array) -> Array:
        """Remove from columns (readings, m), or one (readings,), the part that the unknowns can follow to first order."""
        free = columns.copy()
        for (own, _), rows in zip(self.bases, self.rows, strict=True):
            free[rows] -= own @ (own.T @ free[rows])
        together = sum(shared.T @ free[rows] for (_, shared), rows in zip(self.bases, self.rows, strict=True))
        for (_, shared), rows in zip(self.bases, self.rows, strict=True):
            free[rows] -= shared @ together
        return free

    @cached_property
    def bases(self) -> list[tuple[Array, Array]]:
        """In each window an orthonormal basis of what moves it alone, (n, k), and its rows of that of the shared unknowns.

        The latter (n, s) is of what the former leave of them.
        """
        own, left, shared = [], [], np.flatnonzero(self.pattern.shared)
        for at, block in zip(self.pattern.places, self.blocks, strict=True):
            basis = _orthonormal(block[~self.pattern.shared[at]].T)
            columns = np.zeros((block.shape[1], len(shared)))
            columns[:, np.isin(shared, at)] = block[self.pattern.shared[at]].T
            own.append(basis)
            left.append(columns - basis @ (basis.T @ columns))
        together = _orthonormal(np.concatenate(left))
        return [(basis, together[rows]) for basis, rows in zip(own, self.rows, strict=True)]


def _orthonormal(columns: Array) -> Array:
    """Return an orthonormal basis of those of the columns (n, k) that are not zero."""
    size = np.linalg.norm(columns, axis=0)
    return np.asarray(np.linalg.qr(columns[:, size > 0.0] / size[size > 0.0])[0])
