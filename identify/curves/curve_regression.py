"""Regression on curves: strengths of laws from loss, frequency and centre of several releases, all linear.

Between two points of a curve the loss is the sum of the laws' dampings, the squared frequency the sum of their
stiffnesses, each at the amplitude in between (Krylov and Bogoliubov 1937). Strengths are shared by the releases; a
linear spring and damper may differ a little from one to the next, as rigs do.

Held out: what laws that were fitted to some curves predict of the others.

With several releases each is left out in turn, and its linear spring and damper alone are refitted. One release is cut
in two at the geometric mean of its amplitudes: the large amplitudes predict the small ones, and back, nothing refitted.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.linalg import cholesky_banded, solve_banded

from identify.arrays import Array
from identify.curves.averaged_law import AveragedLaw
from identify.curves.decay_curve import DecayCurve
from identify.effects.force_effect import LinearPart
from identify.fitting.own_linear import shares_of

_CENTRE_COUNTS = 0.5
_RIDGE = 1e-10
_FOLLOWS = 5.0
"""Multiple of the typical loss beyond which a simulated curve no longer follows its laws."""

_TURNED = 2.0
_ECHO = 0.49
"""Correlation of neighbouring differences, a little short of 1/2, for slow forces drift too."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Loss (n - 1,) in 1/s, squared frequency over the mean frequency (n - 1,) in 1/s, and centre (n,) of one curve."""

    loss: Array
    stiffness: Array
    centre: Array

    def minus(self, other: "Rows") -> "Rows":
        """Return what these rows exceed others by."""
        return Rows(self.loss - other.loss, self.stiffness - other.stiffness, self.centre - other.centre)


@dataclass(frozen=True)
class MotionError:
    """What a prediction leaves of one release: of its envelope, of its phase and of its centre, in % of the motion."""

    envelope: float
    phase: float
    centre: float

    @property
    def motion(self) -> float:
        """Envelope and phase together, %."""
        return float(np.hypot(self.envelope, self.phase))


@dataclass(frozen=True, eq=False)
class Strengths:
    """Strengths of some laws (columns,), and what the linear ones of each release add to them (releases, columns)."""

    columns: tuple[int, ...]
    shared: Array
    own: dict[int, Array]

    def of(self, release: int) -> Array:
        """Return the strengths in one release; those shared where it was not fitted."""
        return self.shared + self.own[release] if release in self.own else self.shared


class CurveRegression:
    """Curves of one or more releases, and laws that may explain them; `laws` are the columns.

    `shares` are by how much the spring (relative) and the damper (mean losses) of a release may differ.
    """

    def __init__(
        self,
        curves: Sequence[DecayCurve],
        laws: Sequence[AveragedLaw],
        frequency: float,
        shares: tuple[float, float] | None = None,
    ) -> None:
        self.shares = shares or shares_of(frozenset())
        self.curves = tuple(curves)
        self.laws = tuple(laws)
        self.frequency = frequency
        self.linear = np.array(
            [law.term.force.linear_part in (LinearPart.STIFFNESS, LinearPart.DAMPING) for law in laws]
        )
        self.low = np.array([law.term.effect.strength.low for law in laws])
        self.designs = tuple(self._design(curve) for curve in curves)
        self.measured = tuple(self.rows_of(curve) for curve in curves)
        self._rights: dict[tuple[int, Rows], Array] = {}

    def rows_of(self, curve: DecayCurve) -> Rows:
        """Return what a curve shows, as rows."""
        return Rows(curve.loss, curve.frequency**2 / self.frequency, curve.centre)

    def rows_by(self, curve: DecayCurve, columns: tuple[int, ...], strengths: Array) -> Rows:
        """Return what laws say of a curve, as rows."""
        parts = [self.laws[c].along(curve) for c in columns]
        loss, stiffness, centre = (
            np.sum([s * part[i] for s, part in zip(strengths, parts, strict=True)], axis=0) for i in range(3)
        )
        return Rows(loss, stiffness / self.frequency, centre)

    def excess(self, run: DecayCurve, columns: tuple[int, ...], strengths: Array) -> Rows | None:
        """Return by how much a simulated curve exceeds its own laws: what windows and averaging do to a motion.

        None where the simulated motion does not follow its laws at all.
        """
        found = self.rows_of(run).minus(self.rows_by(run, columns, strengths))
        finite = np.isfinite(found.loss).all() and np.isfinite(found.stiffness).all()
        return found if finite and np.abs(found.loss).max() < _FOLLOWS * self.typical_loss else None

    @cached_property
    def typical_loss(self) -> float:
        """Mean loss over all curves, 1/s."""
        return float(np.mean([np.mean(np.abs(rows.loss)) for rows in self.measured]))

    def _design(self, curve: DecayCurve) -> tuple[Array, Array, Array]:
        parts = [law.along(curve) for law in self.laws]
        loss, stiffness, centre = (np.column_stack([part[i] for part in parts]) for i in range(3))
        return loss, stiffness / self.frequency, centre

    def _weighted(self, release: int) -> tuple[Array, Array, Array, float]:
        curve = self.curves[release]
        weight = curve.between / curve.amplitude.max()
        far = _CENTRE_COUNTS * 2.0 / (float(np.mean(curve.step)) * float(curve.amplitude.max()))
        return weight, weight, np.full(len(curve), far if curve.has_centre else 0.0), far

    @cached_property
    def _normal(self) -> tuple[Array, ...]:
        return tuple(self._cross(i, self._stack_of[i]) for i in range(len(self.curves)))

    def _stack(self, release: int) -> Array:
        return self._whitened(release, *self.designs[release])

    def _whitened(self, release: int, loss: Array, stiffness: Array, centre: Array) -> Array:
        """Return rows (or columns of rows) weighted so that their errors are alike and independent."""
        first, second, third, _ = self._weighted(release)
        shape = (-1,) + (1,) * (loss.ndim - 1)
        level = (centre - centre.mean(axis=0)) * third.reshape(shape)
        parts = [
            _summed(rows * weight.reshape(shape))
            for rows, weight in zip((loss, stiffness), (first, second), strict=True)
        ]
        return np.concatenate([*parts, level])

    def _cross(self, release: int, values: Array) -> Array:
        return np.asarray(self._stack_of[release].T @ values)

    @cached_property
    def _stack_of(self) -> tuple[Array, ...]:
        return tuple(self._stack(i) for i in range(len(self.curves)))

    def _right(self, release: int, rows: Rows) -> Array:
        """Return the products of all columns with some rows; every set of laws is tried on the same few rows."""
        if (release, rows) not in self._rights:
            whitened = self._whitened(release, rows.loss, rows.stiffness, rows.centre)
            self._rights[release, rows] = self._cross(release, whitened)
        return self._rights[release, rows]

    def solve(
        self,
        columns: tuple[int, ...],
        releases: Sequence[int],
        rows: Sequence[Rows],
        *,
        one_record: bool = False,
    ) -> Strengths:
        """Return the strengths of some laws that follow the `rows` of some releases best, within their bounds.

        `rows` has one entry for every release; bounds are kept by leaving a law out that would cross them. Parts of
        `one_record` share their linear laws too.
        """
        right = {i: self._right(i, rows[i]) for i in releases}
        alive = list(range(len(columns)))
        while True:
            kept = tuple(columns[a] for a in alive)
            shared, own = self._solve(kept, releases, right, one_record=one_record)
            wrong = [j for j, c in enumerate(kept) if shared[j] < self.low[c] and not self.linear[c]]
            wrong += [j for j, c in enumerate(kept) if shared[j] < self.low[c] and self.linear[c]]
            if not wrong:
                break
            alive.pop(wrong[0])
        whole = np.zeros(len(columns))
        whole[alive] = shared
        spread = {}
        for i, values in own.items():
            spread[i] = np.zeros(len(columns))
            spread[i][alive] = values
        return Strengths(columns, whole, spread)

    def _solve(
        self,
        columns: tuple[int, ...],
        releases: Sequence[int],
        right: dict[int, Array],
        *,
        one_record: bool,
    ) -> tuple[Array, dict[int, Array]]:
        at = np.array(columns, dtype=int)
        alone = one_record or len(releases) == 1
        loose = np.zeros(0, dtype=int) if alone else np.flatnonzero(self.linear[at])
        size, count = len(at), len(at) + len(loose) * len(releases)
        normal, aim = np.zeros((count, count)), np.zeros(count)
        for r, i in enumerate(releases):
            g, h = self._normal[i][np.ix_(at, at)], right[i][at]
            own = size + r * len(loose) + np.arange(len(loose))
            place = np.concatenate([np.arange(size), own])
            pick = np.concatenate([np.arange(size), loose])
            normal[np.ix_(place, place)] += g[np.ix_(pick, pick)]
            aim[place] += h[pick]
            for j, o in zip(loose, own, strict=True):
                normal[o, o] += self._scatters[i] / self._varies(columns[j]) ** 2
        scale = np.sqrt(np.maximum(np.diag(normal), 1e-300))
        scaled = normal / np.outer(scale, scale) + _RIDGE * np.eye(count)
        found = np.linalg.solve(scaled, aim / scale) / scale
        own_values = {}
        for r, i in enumerate(releases):
            own_values[i] = np.zeros(size)
            own_values[i][loose] = found[size + r * len(loose) :][: len(loose)]
        return found[:size], own_values

    def _varies(self, column: int) -> float:
        """Standard deviation by which a linear law's strength may differ between releases."""
        if self.laws[column].term.force.linear_part == LinearPart.STIFFNESS:
            return self.shares[0] * self.frequency**2
        return self.shares[1] * self.typical_loss

    @cached_property
    def _scatters(self) -> tuple[float, ...]:
        return tuple(self._scatter_of(i) for i in range(len(self.curves)))

    def _scatter_of(self, release: int) -> float:
        """Variance of a weighted row: that of the measured loss about a smooth line, by second differences."""
        loss = self.measured[release].loss * self._weighted(release)[0]
        if len(loss) < 4:
            return float((0.1 * self.typical_loss) ** 2)
        return float(np.mean(np.diff(loss, 2) ** 2) / 6.0) + (1e-3 * self.typical_loss) ** 2

    def predict(self, strengths: Strengths, release: int, rows: Rows) -> Strengths:
        """Return the strengths for a release that was not fitted: its linear laws refitted, all others held."""
        at = np.array(strengths.columns, dtype=int)
        free = np.flatnonzero(self.linear[at])
        held = np.where(self.linear[at], 0.0, strengths.shared)
        g, h = self._normal[release][np.ix_(at, at)], self._right(release, rows)[at]
        values = held.copy()
        prior = [self._scatters[release] / self._varies(strengths.columns[j]) ** 2 for j in free]
        normal = g[np.ix_(free, free)] + np.diag(prior)
        aim = (h - g @ held)[free] + np.array(prior) * strengths.shared[free]
        values[free] = np.linalg.solve(normal, aim)
        return Strengths(strengths.columns, values, {})

    def _counted(self, release: int) -> Array:
        """Return how much each point of a curve counts in the errors, one in all."""
        power = self.curves[release].amplitude ** 2
        return np.asarray(power / np.sum(power))

    def error(self, strengths: Array, columns: tuple[int, ...], release: int, rows: Rows) -> MotionError:
        """Return what laws leave of one release, its start left free; `rows` are what they are to explain."""
        at = list(columns)
        curve, (loss, stiffness, centre) = self.curves[release], self.designs[release]
        weight = self._counted(release)
        decay = np.cumsum(-0.5 * (loss[:, at] @ strengths - rows.loss) * curve.step)
        decay = np.concatenate([[0.0], decay])
        decay -= weight @ decay
        envelope = np.sqrt(weight @ np.clip(np.expm1(np.clip(decay, -3.0, 1.0)), -1.0, 1.0) ** 2)
        speed = np.sqrt(np.maximum(stiffness[:, at] @ strengths * self.frequency, 1e-300))
        true = np.sqrt(np.maximum(rows.stiffness * self.frequency, 1e-300))
        phase = np.concatenate([[0.0], np.cumsum((speed - true) * curve.step)])
        phase -= weight @ phase
        turned = np.sqrt(weight @ np.minimum(phase**2, _TURNED))
        level = centre[:, at] @ strengths - rows.centre
        level -= np.mean(level)
        off = np.sqrt(2.0 * np.mean(level**2) / np.mean(curve.amplitude**2)) if curve.has_centre else 0.0
        return MotionError(100.0 * float(envelope), 100.0 * float(turned), 100.0 * float(off))


def _summed(values: Array) -> Array:
    """Return rows (n,) or (n, columns), differences between neighbours, as rows whose errors are independent.

    Where readings err, what is too large in one difference is too small in the next: a correlation of -1/2.
    """
    n = len(values)
    band = np.zeros((2, n))
    band[0], band[1, :-1] = 1.0, -_ECHO
    factor = cholesky_banded(band, lower=True)
    return np.asarray(solve_banded((1, 0), factor, values))


_FEWEST = 5


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Errors of some laws: `predicted` one for each part that was left out.

    Of `one_record` cut in two the means count the small amplitudes, predicted from the large ones: the way back asks
    small amplitudes for what they hardly show.
    """

    strengths: Strengths
    predicted: tuple[MotionError, ...]
    one_record: bool

    @property
    def counted(self) -> tuple[MotionError, ...]:
        """The errors of prediction that means are taken of."""
        return self.predicted[1:] if self.one_record else self.predicted

    def mean(self, channel: str) -> float:
        """Return the rms over parts of one kind of error ("envelope", "phase", "centre", "motion"), % of the motion."""
        return float(np.sqrt(np.mean([getattr(error, channel) ** 2 for error in self.counted])))

    def typical(self, channel: str) -> float:
        """Return the median over the parts that were left out, % of the motion."""
        return float(np.median([getattr(error, channel) for error in self.counted]))

    def better(self, other: "HeldOut", channel: str) -> int:
        """Return on how many parts the prediction is better than another's."""
        pairs = zip(self.predicted, other.predicted, strict=True)
        return sum(getattr(mine, channel) < getattr(theirs, channel) for mine, theirs in pairs)


def cut_by_amplitude(curve: DecayCurve) -> tuple[DecayCurve, ...]:
    """Return the large, middle and small amplitudes of a curve, equal in ratio, one point in common between neighbours.

    Two parts where it is too short for three, the whole where it is too short for two.
    """
    size = np.log(curve.amplitude)
    for parts in (3, 2):
        if len(curve) <= parts * _FEWEST:
            continue
        levels = np.linspace(size.max(), size.min(), parts + 1)[1:-1]
        edges = [0, *(int(np.argmin(np.abs(size - level))) for level in levels), len(curve) - 1]
        for i in range(1, parts):
            edges[i] = max(edges[i], edges[i - 1] + _FEWEST)
        for i in range(parts - 1, 0, -1):
            edges[i] = min(edges[i], edges[i + 1] - _FEWEST)
        return tuple(curve.part(first, last + 1) for first, last in pairwise(edges))
    return (curve,)


def hold_out(
    regression: CurveRegression, columns: tuple[int, ...], rows: Sequence[Rows], *, one_record: bool
) -> HeldOut:
    """Return what some laws predict of each curve from the others, and their strengths when fitted to all."""
    everything = list(range(len(regression.curves)))
    predicted = []
    for left in everything if len(everything) > 1 else ():
        others = [i for i in everything if i != left]
        found = regression.solve(columns, others, rows, one_record=one_record)
        if not one_record:
            found = regression.predict(found, left, rows[left])
        predicted.append(regression.error(found.shared, columns, left, rows[left]))
    whole = regression.solve(columns, everything, rows, one_record=one_record)
    return HeldOut(whole, tuple(predicted), one_record)
