"""The Jacobian in blocks: of each window only the unknowns that move it.

Windows share the physics, and each has a start, lag, gain and offsets of its own, which move no other window. What one
release has of its own moves its windows, and a last block besides: where it is expected. All other entries are zero; they
are not kept, not multiplied, and not changed by what a step teaches.

The tangent: all changes of the readings that a fit's own parameters can follow, to first order.

An orthonormal basis of them, in two parts: directions that move one window only, and those of the shared physics, which
move all, less what the former follow of them.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Self

import numpy as np
from numpy.typing import NDArray

from identify.arrays import Array, Mask


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

    @property
    def places(self) -> tuple[NDArray[np.int_], ...]:
        """The unknowns of each window."""
        return self.pattern.places

    @property
    def shared(self) -> Mask:
        """Which unknowns are those of several windows, (unknowns,)."""
        return self.pattern.shared

    def __len__(self) -> int:
        """Return the number of readings in all windows."""
        return sum(block.shape[1] for block in self.blocks)

    @property
    def rows(self) -> list[slice]:
        """Where the readings of each window stand among all."""
        return rows_of([block.shape[1] for block in self.blocks])

    def of_unknown(self, j: int) -> Iterator[tuple[int, Array]]:
        """Yield each window that unknown j moves with its row there, (n,), which may be written to."""
        for i, row in self.pattern.found[j]:
            yield i, self.blocks[i][row]

    def column(self, j: int) -> Array:
        """Return how all readings change with unknown j, (readings,)."""
        full = np.zeros(len(self))
        rows = self.rows
        for i, values in self.of_unknown(j):
            full[rows[i]] = values
        return full

    def change(self, step: Array) -> Array:
        """Return how the misfit changes by a small step of the unknowns, (readings,)."""
        return np.concatenate([step[at] @ block for at, block in zip(self.places, self.blocks, strict=True)])

    def gradient(self, misfit: Array) -> Array:
        """Return the products of all columns with a misfit (readings,), (unknowns,)."""
        total = np.zeros(len(self.shared))
        for at, block, rows in zip(self.places, self.blocks, self.rows, strict=True):
            total[at] += block @ misfit[rows]
        return total

    def normal(self) -> Array:
        """Return the products of all columns with one another, (unknowns, unknowns)."""
        total = np.zeros((len(self.shared), len(self.shared)))
        for at, block in zip(self.places, self.blocks, strict=True):
            total[np.ix_(at, at)] += block @ block.T
        return total

    def mended(self, step: Array, size: Array, surprise: Array) -> Self:
        """Return the one nearest to this that agrees with a step after which the misfit was off by `surprise`.

        `size` (unknowns,) is what each unknown is measured in. Entries that are zero by nature stay so (Broyden, 1965,
        eq. 4.5, in each window with its own unknowns: Schubert, Math. Comp. 24, 1970). A window that a step has hardly
        moved teaches nothing but rounding.
        """
        blocks, largest = [], float(np.sum((step / size) ** 2))
        for at, block, rows in zip(self.places, self.blocks, self.rows, strict=True):
            moved = step[at] / size[at]
            square = float(moved @ moved)
            if square > _STOOD_STILL * largest:
                block = block + np.outer(moved / size[at] / square, surprise[rows])
            blocks.append(block)
        return type(self)(self.pattern, tuple(blocks))

    def tangent(self, kept: Mask | None = None) -> Tangent:
        """Return what the unknowns, or those `kept` of them, can follow."""
        kept = np.ones(len(self.shared), dtype=bool) if kept is None else kept
        if len(self.blocks) == 1:
            return Tangent.of((self.blocks[0][kept[self.places[0]]],), None)
        own = [block[kept[at] & ~self.shared[at]] for at, block in zip(self.places, self.blocks, strict=True)]
        shared = np.flatnonzero(kept & self.shared)
        return Tangent.of(own, [self._rows_in(i, shared) for i in range(len(self.blocks))])

    def _rows_in(self, i: int, unknowns: NDArray[np.int_]) -> Array:
        """Return the rows of block i of some unknowns, 0 of those that do not move it, (unknowns, n)."""
        block, at = self.blocks[i], self.places[i]
        rows = np.zeros((len(unknowns), block.shape[1]))
        here = np.isin(unknowns, at)
        rows[here] = block[np.searchsorted(at, unknowns[here])]
        return rows


def rows_of(readings: Sequence[int]) -> list[slice]:
    """Return where the readings of each window stand among all, from their numbers."""
    ends = np.cumsum([0, *readings]).tolist()
    return [slice(a, b) for a, b in pairwise(ends)]
