"""The Jacobian in blocks: of each window only the unknowns that move it.

Windows share the physics, and each has a start, lag, gain and offsets of its own, which move no other window. All
other entries are zero; they are not kept, not multiplied, and not changed by what a step teaches.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Self

import numpy as np
from numpy.typing import NDArray

from identify.arrays import Array, Mask
from identify.fitting.tangent import Tangent

_STOOD_STILL = 1e-12
"""Share of a step's square that lies in a window below which it was not moved."""


@dataclass(frozen=True, eq=False)
class BlockPattern:
    """Which unknowns move which windows: `places[i]` are those of window i, `shared` (unknowns,) marks those of all.

    `found[j]` lists the windows that unknown j moves, each with its place among that window's own.
    """

    places: tuple[NDArray[np.int_], ...]
    shared: Mask
    found: tuple[tuple[tuple[int, int], ...], ...]

    @classmethod
    def of(cls, window_of: Sequence[int], windows: int) -> Self:
        """Return the pattern of unknowns that belong to `window_of` (-1: to all) of so many windows."""
        owner = np.array(window_of)
        places = tuple(np.flatnonzero((owner == -1) | (owner == i)) for i in range(windows))
        found: list[list[tuple[int, int]]] = [[] for _ in window_of]
        for i, at in enumerate(places):
            for row, j in enumerate(at.tolist()):
                found[j].append((i, row))
        return cls(places, owner == -1, tuple(tuple(one) for one in found))


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
        """Which unknowns are those of all windows, (unknowns,)."""
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
        common = [
            block[kept[at] & self.shared[at]] for at, block in zip(self.places, self.blocks, strict=True)
        ]
        return Tangent.of(own, common)


def rows_of(readings: Sequence[int]) -> list[slice]:
    """Return where the readings of each window stand among all, from their numbers."""
    ends = np.cumsum([0, *readings]).tolist()
    return [slice(a, b) for a, b in pairwise(ends)]
