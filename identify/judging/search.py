"""Screening: which two or three forces together explain most of what a model leaves, by equation error.

Effects may hide each other, so that none looks good alone. Along the measured motion each is a column, and all triples of
columns cost no more than a tenth of a second; only the best are worth a fit.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identify.arrays import Array
from identify.effects.effect import Scales
from identify.fitting.initial_values import term_starts
from identify.model.measured_path import force_along
from identify.model.model import Model, Term
from identify.preprocessing.equation_error import moving
from identify.preprocessing.prepared_decay import PreparedDecay

_FITTED = 6
"""Sets of as many effects that are worth a fit."""

_INDEPENDENT = 1e-6
"""Share of a column that the model and the other column must leave free."""


@dataclass(frozen=True, eq=False)
class Begun:
    """An effect with values of its inner parameters, by their own names, from which a fit may begin."""

    term: Term
    inner: dict[str, float]

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.term.effect.name


@dataclass(frozen=True, eq=False)
class _Columns:
    """Forces of unit strength along a motion, without the part that a model follows, scaled to unit length.

    The last column is no force. `begun` has the effect of each other column, with its inner parameters. `along`
    (columns,) is the part of the model's misfit along each column, `overlap` (columns, columns) their products; `left`
    is the sum of squares that the model leaves.
    """

    begun: tuple[Begun, ...]
    along: Array
    overlap: Array
    left: float

    def left_beside(self, i: int) -> Array:
        """Return the sum of squares that column i leaves together with each two others, (columns, columns)."""
        along = self.along - self.overlap[i] * self.along[i]
        overlap = self.overlap - np.outer(self.overlap[i], self.overlap[i])
        square = np.diag(overlap)
        over = np.where(square > _INDEPENDENT, 1.0 / np.sqrt(np.maximum(square, _INDEPENDENT)), 0.0)
        explained = _explained_by_two(along * over, overlap * np.outer(over, over))
        return np.asarray(np.maximum(self.left - self.along[i] ** 2 - explained, 0.0))

    def forwards(self, places: tuple[int, ...]) -> tuple[Begun, ...]:
        """Return the effects of some columns; a line that would act backwards begins half a cycle later."""
        acting = [j for j in places if j < len(self.begun)]
        strengths = np.linalg.lstsq(self.overlap[np.ix_(acting, acting)], self.along[acting], rcond=None)[0]
        opposite = [int(np.argmin(self.overlap[j])) for j in acting]
        turned = [
            o if strength < 0.0 and self.overlap[j, o] < _INDEPENDENT - 1.0 else j
            for j, o, strength in zip(acting, opposite, strengths, strict=True)
        ]
        return tuple(self.begun[j] for j in turned)


def promising_sets(
    prepared: PreparedDecay, model: Model, terms: tuple[Term, ...], scales: Scales
) -> tuple[list[tuple[Begun, ...]], list[tuple[Begun, ...]]]:
    """Find the pairs and the triples of forces that leave the least of the restoring force, the best first.

    Each effect is tried at all starting values of its inner parameters; strengths are free, of either sign.
    """
    columns = _free_columns(prepared, model, terms, scales)
    if columns is None:
        return [], []
    names = [*(begun.name for begun in columns.begun), ""]
    first = [at for at, name in enumerate(names) if at == 0 or name != names[at - 1]]
    effect = np.repeat(np.arange(len(first), dtype=np.int64), np.diff([*first, len(names)]))
    lefts = []
    for i in range(len(columns.begun)):
        left = _of_different(columns.left_beside(i), effect, i)
        lefts.append(np.minimum.reduceat(np.minimum.reduceat(left, first, axis=0), first, axis=1))
    of_effects = np.array(lefts)
    two, three = of_effects.copy(), of_effects
    two[:, :, :-1] = np.inf
    three[:, :, -1] = three[:, -1, :] = np.inf
    return _least(columns, effect, two), _least(columns, effect, three)


def _of_different(left: Array, effect: NDArray[np.int64], i: int) -> Array:
    """Mask sums of squares beside column i: infinite where two of the three columns are of one effect."""
    alike = effect[:, None] == effect
    own = effect == effect[i]
    return np.where(alike | own[:, None] | own, np.inf, left)


def _least(columns: _Columns, effect: NDArray[np.int64], left: Array) -> list[tuple[Begun, ...]]:
    """Select the few sets of effects that leave the least, each with its columns.

    `left` (columns, effects, effects) is what each column leaves with the best columns of two effects.
    """
    found: dict[frozenset[int], tuple[Begun, ...]] = {}
    for at in np.argsort(left, axis=None):
        i, m, n = (int(place) for place in np.unravel_index(at, left.shape))
        if len(found) == _FITTED or not np.isfinite(left[i, m, n]):
            break
        key = frozenset((int(effect[i]), m, n))
        if key not in found:
            beside = np.where((effect == m)[:, None] & (effect == n), columns.left_beside(i), np.inf)
            found[key] = columns.forwards((i, *divmod(int(np.argmin(beside)), len(beside))))
    return list(found.values())


def _free_columns(
    prepared: PreparedDecay, model: Model, terms: tuple[Term, ...], scales: Scales
) -> _Columns | None:
    begun, columns = _columns(prepared, terms, scales)
    if len({one.name for one in begun}) < 2:
        return None
    used = moving(prepared.motion)
    _, known = _columns(prepared, model.forces, scales)
    basis = np.linalg.qr(np.column_stack([*known, np.ones(len(used))])[used])[0]
    design = np.column_stack([*columns, np.zeros(len(used))])[used]
    design = design / np.maximum(np.linalg.norm(design, axis=0), 1e-300)
    free = design - basis @ (basis.T @ design)
    size = np.linalg.norm(free, axis=0)
    free = np.where(size > _INDEPENDENT, free / np.maximum(size, _INDEPENDENT), 0.0)
    left = prepared.restoring[used] - basis @ (basis.T @ prepared.restoring[used])
    return _Columns(tuple(begun), free.T @ left, free.T @ free, float(left @ left))


def _columns(
    prepared: PreparedDecay, terms: tuple[Term, ...], scales: Scales
) -> tuple[list[Begun], list[Array]]:
    """Compute the finite forces of unit strength along the motion, (n,) each, with their effects."""
    motion = prepared.motion
    begun, columns = [], []
    for term in (term for term in terms if term.is_force):
        for inner in term_starts(term, scales):
            along = (prepared.time, motion.displacement, motion.velocity, prepared.frequency)
            force = force_along(term, inner, *along)
            if np.isfinite(force).all():
                begun.append(Begun(term, inner))
                columns.append(force)
    return begun, columns


def _explained_by_two(alone: Array, overlap: Array) -> Array:
    """Return the sum of squares that each pair of unit columns explains, (columns, columns)."""
    apart = 1.0 - overlap**2
    both = alone[:, None] ** 2 + alone[None, :] ** 2 - 2.0 * overlap * np.outer(alone, alone)
    return np.where(apart > _INDEPENDENT, both / np.maximum(apart, _INDEPENDENT), 0.0)
