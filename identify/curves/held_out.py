"""Held-out parts: laws are fitted to some parts of the curves and predict the others.

With several releases each is left out in turn, and its linear spring and damper alone are refitted. One record is cut in
ranges of its amplitudes, and each is predicted from the others, nothing refitted.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from identify.arrays import Array
from identify.curves.curve_laws import Signals
from identify.curves.decay_curve import THIRD_DIFFERENCES, DecayCurve
from identify.curves.likelihood import CurveFit, CurveLikelihood, Part, Products, Settings

_FEWEST = 5
"""Points of a part at least."""

_ROUNDS = 2
"""Times that windows and averaging are corrected for by the laws as fitted."""

_TURNED = 2.0
"""Largest square of an error of the phase, rad^2: what is out of step is no more wrong than by a cycle."""


@dataclass(frozen=True)
class MotionError:
    """The prediction error of one part: of its envelope and its phase, in % of the motion."""

    envelope: float
    phase: float

    @property
    def motion(self) -> float:
        """Envelope and phase together, %."""
        return float(np.hypot(self.envelope, self.phase))


@dataclass(frozen=True, eq=False)
class HeldOut:
    """The prediction by laws of some strengths (columns,): an error for each part that was left out.

    In `one_record` the largest amplitudes do not count: the small ones hardly predict them.
    """

    strengths: Array
    predicted: tuple[MotionError, ...]
    one_record: bool

    def typical(self, channel: str) -> float:
        """Return the rms over the parts of one kind of error ("envelope", "phase", "motion"), % of the motion."""
        counted = self.predicted[1:] if self.one_record else self.predicted
        return float(np.sqrt(np.mean([getattr(error, channel) ** 2 for error in counted])))

    def better(self, other: "HeldOut", channel: str) -> int:
        """Count the parts on which the prediction is better than another's."""
        pairs = zip(self.predicted, other.predicted, strict=True)
        return sum(getattr(mine, channel) < getattr(theirs, channel) for mine, theirs in pairs)


def parts_of(likelihood: CurveLikelihood) -> tuple[Part, ...]:
    """List the parts to leave out in turn: releases, or ranges of amplitude of one; one part where it is too short."""
    curves = likelihood.laws.curves
    if len(curves) > 1:
        return tuple((i, slice(None)) for i in range(len(curves)))
    return tuple((0, cut) for cut in cut_by_amplitude(curves[0]))


def cut_by_amplitude(curve: DecayCurve) -> tuple[slice, ...]:
    """Cut a curve into large, middle and small amplitudes of equal ratio; neighbours have one point in common.

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
        return tuple(slice(first, last + 1) for first, last in pairwise(edges))
    return (slice(None),)


def hold_out(likelihood: CurveLikelihood, found: CurveFit) -> HeldOut:
    """Predict each part of the curves from the others by the laws of a fit alone.

    Walks and a law outside the library predict nothing: the residual of the laws counts as scatter and drift.
    """
    columns, still = likelihood.columns(found.added), (0,) * len(found.settings)
    noise, strengths = _scatter(likelihood), found.strengths
    for _ in range(_ROUNDS):
        observed = likelihood.laws.observed(columns, strengths)
        whole = likelihood.fitted(likelihood.products(observed, columns, scatter=noise), found.added, still)
        strengths = whole.strengths
    parts = parts_of(likelihood)
    predicted = []
    for left in parts:
        rest = [part for part in parts if part is not left]
        others, own = (likelihood.products(observed, columns, some, noise) for some in (rest, [left]))
        shared = likelihood.fitted(others, found.added, still).shared
        refitted = _own(likelihood, own, columns, still, shared)
        predicted.append(_error(likelihood, columns, refitted, left, observed))
    return HeldOut(whole.shared, tuple(predicted), len(likelihood.rigs) == 1)


def _scatter(likelihood: CurveLikelihood) -> float:
    """Estimate the error of an amplitude (m or rad) from the third differences of the curves; at least a thousandth."""
    curves = likelihood.laws.curves
    squares = [np.mean(np.diff(curve.amplitude, 3) ** 2) / THIRD_DIFFERENCES for curve in curves]
    return float(np.sqrt(np.mean(squares))) + 1e-3 * max(float(curve.amplitude.max()) for curve in curves)


def _own(
    likelihood: CurveLikelihood,
    products: Products,
    columns: tuple[int, ...],
    still: Settings,
    shared: Array,
) -> Array:
    """Refit the linear laws of a release that was left out near the shared ones; all others are held (columns,)."""
    count = len(likelihood.own)
    if not count:
        return shared
    (release, _) = products.parts[0]
    joined, _ = products.joined([products.used.index(column) for column in columns], still)
    own = slice(len(columns) + release * count, len(columns) + (release + 1) * count)
    normal = np.eye(count) + joined[own, own]
    aim = joined[own, -1] - joined[own, : len(columns)] @ shared
    strengths = shared.copy()
    for (column, varies), more in zip(likelihood.own, np.linalg.solve(normal, aim), strict=True):
        strengths[columns.index(column)] += varies * more
    return strengths


def _error(
    likelihood: CurveLikelihood,
    columns: tuple[int, ...],
    strengths: Array,
    part: Part,
    observed: tuple[Signals, ...],
) -> MotionError:
    """Compute the prediction error of one part, with its start left free."""
    release, points = part
    curve, at = likelihood.laws.curves[release], list(columns)
    size, phase, _ = (
        (law[:, at] @ strengths - seen)[points]
        for law, seen in zip(likelihood.laws.columns[release], observed[release], strict=True)
    )
    power = curve.amplitude[points] ** 2
    weight = power / np.sum(power)
    envelope = np.clip(np.expm1(np.clip(size - weight @ size, -3.0, 1.0)), -1.0, 1.0)
    turned = np.minimum((phase - weight @ phase) ** 2, _TURNED)
    return MotionError(100.0 * float(np.sqrt(weight @ envelope**2)), 100.0 * float(np.sqrt(weight @ turned)))
