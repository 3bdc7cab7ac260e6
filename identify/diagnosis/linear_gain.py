"""The linear gain: by how much one more effect lowers chi-square, were the misfit linear in its strength.

Where a model is so near the truth that a small force moves its prediction in proportion, one run for each value of an
effect's inner parameters tells, before any fit, nearly what a fit would: what the model's own parameters can follow of
the misfit, and of the change that the effect makes, is left out. Memory that starts anywhere, and faults that act out of
proportion, may gain more.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from identify.arrays import Array
from identify.diagnosis.weak_presence import probes, with_fault
from identify.effects.effect import Scales
from identify.fitting.block_jacobian import BlockJacobian
from identify.fitting.fit import Fit
from identify.fitting.initial_values import reachable_starts, term_starts
from identify.fitting.jacobian import linearise
from identify.fitting.problem import Problem
from identify.model.model import Term
from identify.preprocessing.prepared_decay import PreparedDecay

LINEAR_UP_TO = 100.0
"""Reduced chi-square up to which one more effect moves the readings in proportion; beyond, gains are far beyond chance."""

Starts = tuple[dict[str, float], ...]
"""Values of a term's inner parameters by their own names, one dictionary for each place from which a fit may begin."""

_PRESENT = 1e-5
"""Share of the acceleration that the probed force has: it moves the readings by a few units of noise."""

_MEMORY_LEAVES = 0.85
_LEAVES = 0.5
"""Share of chi-square that may be left, by linear gain, of a term that is worth a fit; of one with memory more."""

_OUT_OF_PROPORTION_LEAVES = 1.0
"""The same of a fault that acts out of proportion, up to a misfit of `_LARGE` times the noise."""

_LARGE = 30.0
_ENOUGH = 150
"""Starting values of one term: of more, every second is left out, or two of three, for what is left need not be close."""

_FEWEST_PLACES, _MOST_NUMBERS = 100, 2_000_000
"""Places of one force among which the largest gain is sought, and numbers in its columns where there are more."""

_INDEPENDENT = 1e-6
"""Size of a direction, as a share of the largest, that counts as none."""

_NEAR = 1.5
"""Multiple of the goal below which every term is worth a fit."""


@dataclass(frozen=True, eq=False)
class Slope:
    """How the misfit of a fit depends on its unknowns: the fit, its problem, misfit (n,) and Jacobian."""

    base: Fit
    problem: Problem
    residual: Array
    jacobian: BlockJacobian

    @classmethod
    def of(cls, base: Fit) -> Self:
        """Return the slope at a fit."""
        problem = Problem(base.model, base.windows, base.frequency)
        return cls(base, problem, *linearise(problem, base.theta))

    def free_of_known(self, columns: Array) -> Array:
        """Return what the model's own parameters cannot follow of columns (n, m)."""
        return self.jacobian.tangent().free(columns)


def worth_a_fit(
    decays: tuple[PreparedDecay, ...],
    slope: Slope,
    terms: tuple[Term, ...],
    scales: Scales,
    goal: float,
) -> tuple[Term, ...]:
    """Return the terms that may bring a fit's chi-square to a `goal`, or half of the way."""
    bases = [slope.residual]
    changes: list[list[Array]] = []
    for term in terms:
        changes.append(_changes(decays, slope, term, scales))
        bases += changes[-1]
    free = slope.free_of_known(np.column_stack(bases))
    misfit, cost = free[:, 0], slope.base.chi_square
    follows = float(misfit @ misfit)  # a parameter at its bound may be freed by what is added
    size = np.maximum(np.sum(free**2, axis=0), 1e-300)
    along = misfit @ free
    kept, first = [], 1
    for term, columns in zip(terms, changes, strict=True):
        own = slice(first, first + len(columns))
        first += len(columns)
        gain = along[own] ** 2 / size[own]
        if term.is_force and term.effect.one_sided and not term.force.states:
            gain = np.where(along[own] < 0.0, gain, 0.0)
        most = float(np.max(gain, initial=0.0))
        if follows - most <= max(_NEAR * goal, _left(term, slope.base) * cost):
            kept.append(term)
    return tuple(kept)


def likeliest(decays: tuple[PreparedDecay, ...], slope: Slope, term: Term, scales: Scales) -> Starts:
    """Return the places at which the linear gain of a force is larger than at their neighbours, the largest first.

    None of a fault. A line's are those of the residual's own lines.
    """
    starts = (term_starts if term.effect.line else reachable_starts)(term, scales)
    if not term.is_force or len(starts) < 2:
        return ()
    base = slope.base
    problem = Problem(base.model.plus(term), base.windows, base.frequency, coarse=True)
    before = Problem(base.model, base.windows, base.frequency, coarse=True).residuals(base.theta)
    starts = starts[:: len(starts) // max(_FEWEST_PLACES, _MOST_NUMBERS // len(before)) + 1]
    columns, of = [slope.residual], [-1]
    for place, start in enumerate(starts):
        moved = [
            problem.residuals(p) for p in probes(decays, base, problem, term, start, _PRESENT, early=True)
        ]
        if all(np.isfinite(one).all() for one in moved):
            own = [moved[0] - before, *(one - moved[0] for one in moved[1:])] if moved else []
            columns += own
            of += [place] * len(own)
    free, owner = slope.free_of_known(np.column_stack(columns)), np.array(of)
    gains = [0.0, *(_gain(free[:, 0], free[:, owner == place], term) for place in range(len(starts))), 0.0]
    tops = [i for i in range(1, len(gains) - 1) if 0.0 < gains[i] >= max(gains[i - 1], gains[i + 1])]
    return tuple(starts[i - 1] for i in sorted(tops, key=lambda i: -gains[i]))


def _gain(misfit: Array, columns: Array, term: Term) -> float:
    """Return by how much a force lowers chi-square with its strength and states free, each a column (n, columns)."""
    if columns.shape[1] == 1 and term.effect.one_sided and misfit @ columns[:, 0] > 0.0:
        return 0.0
    basis, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    kept = sizes > _INDEPENDENT * max(sizes, default=0.0)
    return float(np.sum((basis[:, kept].T @ misfit) ** 2))


def _left(term: Term, base: Fit) -> float:
    """Return the share of chi-square that the linear gain of a term may leave."""
    if not term.is_force and term.fault.held_at_first:
        return _OUT_OF_PROPORTION_LEAVES if base.reduced < _LARGE else _MEMORY_LEAVES
    if not term.is_force:
        return _LEAVES
    return _MEMORY_LEAVES if term.force.states else _LEAVES


def _changes(decays: tuple[PreparedDecay, ...], slope: Slope, term: Term, scales: Scales) -> list[Array]:
    """Return by how much a weak presence of a term changes the misfit, (n,) for each of its starting values."""
    base = slope.base
    if _left(term, base) >= 1.0:
        return []
    problem = Problem(base.model.plus(term), base.windows, base.frequency, coarse=True)
    changes = []
    starts = term_starts(term, scales, fine=True)
    for start in starts[:: len(starts) // _ENOUGH + 1]:
        if term.is_force:
            points = probes(decays, base, problem, term, start, _PRESENT)
        else:
            points = [problem.theta(with_fault(base, term, start))]
        changes += [problem.residuals(point) - slope.residual for point in points]
    return [change for change in changes if np.isfinite(change).all()]
