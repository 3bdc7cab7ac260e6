"""Faults of a sensor by chance: how much one would lower chi-square if there were none, of each draw of noise.

Some faults act out of proportion: a corner frequency gives the size of its effect with its shape. So each starting value
stands for the sizes between its neighbours', the weakest also for all below. What such a fault has in proportion beside
it, as what it remembers of the time before the fit, is free at every one of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from identify.arrays import Array
from identify.diagnosis.null_lines import rows_of
from identify.diagnosis.weak_presence import with_fault
from identify.effects.effect import Scales
from identify.fitting.fit import Fit
from identify.fitting.initial_values import reachable_starts
from identify.fitting.problem import Problem
from identify.fitting.tangent import Tangent
from identify.model.model import Term
from identify.model.simulate import Response

_SMALL = 1e-3
"""Share of the largest reading by which what a fault adds in proportion is tried."""

_FOLLOWED = 1e-6
"""Share of a change's norm below which what the fit's own parameters leave of it is rounding."""

_SWEEPS = 12
"""Times that the shares of several releases are made the best ones in turn."""

_NONE = 1e-9
"""Norm of a change, in units of the noise, that is none."""


@dataclass(frozen=True, eq=False)
class _Change:
    """What a fault at one starting value changes of the misfit (n,), and what its parameters in proportion add."""

    whole: Array
    beside: tuple[Array, ...]


@dataclass(frozen=True, eq=False)
class _Split:
    """The same in parts (n,) that each have a size of their own: those of one release, or of each of several."""

    parts: list[Array]
    beside: list[Array]


def fault_drops(base: Fit, term: Term, scales: Scales, tangent: Tangent, noise: Array) -> Array:
    """Sum over the releases of the best drop by a fault that each has with parameters of its own, (draws,).

    `noise` (readings, draws) is less what the fit's parameters follow, and of the sign in which readings differ from it.
    """
    readings = _Readings.of(base, term)
    changes = [_change(readings, start, scales) for start in reachable_starts(term, scales)]
    changes = [change for change in changes if np.isfinite(change.whole).all()]
    total, every = np.zeros(noise.shape[1]), rows_of(base.windows)
    for i, rows in enumerate(every):
        followed = _Followed.of(tangent.part(i))
        drawn = followed.whitened(noise[rows])
        wholes = [followed.left_of(change.whole[rows]) for change in changes]
        if not term.fault.held_at_first:  # the starts are directions, all of which are free
            total += _along(_independent(wholes, len(drawn)), drawn)
            continue
        besides = [[followed.left_of(b[rows]) for b in change.beside] for change in changes]
        total += _of_sizes([_Split([w], b) for w, b in zip(wholes, besides, strict=True)], drawn)
    if term.fault.held_at_first and len(every) > 1:
        total = np.maximum(total, _of_one_sensor(changes, every, tangent, noise))
    return total


def _of_one_sensor(changes: list[_Change], every: list[slice], tangent: Tangent, noise: Array) -> Array:
    """Return the largest drop over the starting values by a fault that is much the same in all releases, (draws,).

    What is common to all, the parameters that they share follow better than what one of them has alone.
    """

    def parts(column: Array) -> list[Array]:
        """Return what is left of a column in each release, the others without it."""
        found = [np.zeros_like(column) for _ in every]
        for own, rows in zip(found, every, strict=True):
            own[rows] = column[rows]
        return [tangent.free(own) for own in found]

    split = [_Split(parts(c.whole), [own for column in c.beside for own in parts(column)]) for c in changes]
    return _of_sizes(split, noise)


@dataclass(frozen=True, eq=False)
class _Followed:
    """What a fit's parameters follow of one release: wholly in directions of its own, in part in those of all releases.

    Of a column (n,) that moves this release only, the parameters of all leave a column that moves the others, too. Both it
    and noise that is free of the parameters are turned into vectors (n,) with the same lengths and products: of each
    `directions` (n, k) the share `left` (k,) of a column's, and of noise as much more.
    """

    directions: Array
    left: Array

    @classmethod
    def of(cls, part: Array) -> Self:
        """Return it from the rows (n, k) of one release of an orthonormal basis for all."""
        directions, sizes, _ = np.linalg.svd(part, full_matrices=False)
        return cls(directions, np.sqrt(np.maximum(1.0 - sizes**2, 0.0)))

    def left_of(self, column: Array) -> Array:
        """Return what is left of a column (n,); zeros where that is rounding."""
        found = column - self.directions @ ((1.0 - self.left) * (self.directions.T @ column))
        counts = np.linalg.norm(found) > _FOLLOWED * np.linalg.norm(column) + _NONE
        return np.asarray(found if counts else np.zeros_like(found))

    def whitened(self, noise: Array) -> Array:
        """Return noise (n, draws) of unit variance in all directions that are left."""
        more = np.divide(1.0, self.left, out=np.zeros_like(self.left), where=self.left > _FOLLOWED) - 1.0
        return np.asarray(noise + self.directions @ (more[:, None] * (self.directions.T @ noise)))


@dataclass(frozen=True, eq=False)
class _Readings:
    """A fit's motion, which no fault of a sensor changes, as it is read; and the misfit without the fault, (n,)."""

    base: Fit
    term: Term
    problem: Problem
    motion: tuple[Response, ...]
    before: Array

    @classmethod
    def of(cls, base: Fit, term: Term) -> Self:
        """Simulate a fit's motion once."""
        usual = Problem(base.model, base.windows, base.frequency)
        motion = tuple(usual.responses(base.theta))
        return cls(
            base,
            term,
            Problem(base.model.plus(term), base.windows, base.frequency),
            motion,
            usual.residuals(base.theta),
        )

    def misfit(self, start: dict[str, float]) -> Array:
        """Return the misfit (n,) with the fault in every release."""
        theta = self.problem.theta(with_fault(self.base, self.term, start))
        read = (self.problem.read(theta, i, motion) for i, motion in enumerate(self.motion))
        off = [self.problem.residual_of(i, predicted) for i, predicted in enumerate(read)]
        return np.concatenate([*off, *self.problem.off_expected(theta)])


def _change(readings: _Readings, start: dict[str, float], scales: Scales) -> _Change:
    fault, found, beside = readings.term.fault, readings.misfit(start), []
    for parameter in fault.parameters if fault.held_at_first else ():
        if parameter.unit == "reading" and parameter.name not in fault.held_at_first:
            moved = start[parameter.name] + _SMALL * scales.peaks[readings.term.channel]
            beside.append(readings.misfit(start | {parameter.name: moved}) - found)
    return _Change(found - readings.before, tuple(beside))


def _independent(columns: Sequence[Array], n: int) -> Array:
    """Return an orthonormal basis (n, k) of some columns (n,), in their order."""
    kept: list[Array] = []
    for column in columns:
        left = column
        for other in kept:
            left = left - other * float(other @ left)
        size = float(np.linalg.norm(left))
        if size > _FOLLOWED * float(np.linalg.norm(column)) + _NONE:
            kept.append(left / size)
    return np.column_stack(kept) if kept else np.zeros((n, 0))


def _along(directions: Array, noise: Array) -> Array:
    return np.asarray(np.sum((directions.T @ noise) ** 2, axis=0))


def _of_sizes(changes: list[_Split], noise: Array) -> Array:
    """Return the largest drop over the starting values, each with the sizes that it stands for, (draws,)."""
    best = np.zeros(noise.shape[1])
    found = []
    for change in changes:
        beside = _independent(change.beside, len(noise))
        whole = np.column_stack(change.parts)
        size = float(np.linalg.norm(whole.sum(axis=1)))
        found.append((size, whole - beside @ (beside.T @ whole), beside))
    found.sort(key=lambda one: one[0])
    sizes = [size for size, _, _ in found]
    for j, (size, whole, beside) in enumerate(found):
        low = np.sqrt(sizes[j - 1] / size) if j and size > 0.0 else 0.0
        high = np.sqrt(sizes[j + 1] / size) if j + 1 < len(found) and size > 0.0 else 1.0
        rounding = _FOLLOWED**2 * size**2 + 1e-18
        best = np.maximum(best, drop_by_shares(whole, noise, low, high, rounding) + _along(beside, noise))
    return best


def drop_by_shares(parts: Array, noise: Array, low: float, high: float, rounding: float) -> Array:
    """Return the largest drop by columns (n, parts) of which any shares between two are there, (draws,).

    Each share in its turn is made the best one beside the others, which climbs to the top of a concave function. Parts
    whose square is `rounding` are none.
    """
    together, along = parts.T @ parts, parts.T @ noise
    counts = np.diag(together) > rounding
    together, along = together[np.ix_(counts, counts)], along[counts]
    share = np.full_like(along, low)
    for _ in range(_SWEEPS if len(along) > 1 else 1):
        for i, own in enumerate(np.diag(together)):
            beyond = along[i] - together[i] @ share + own * share[i]
            share[i] = np.clip(beyond / own, low, high)
    return np.asarray(np.sum(share * (2.0 * along - together @ share), axis=0))
