"""Prediction: what physics that is held foretells of a release that it was not fitted to."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, Mask
from identify.effects.force_effect import LinearPart
from identify.estimate import Estimate
from identify.fitting.initial_values import initial_values
from identify.fitting.levenberg_marquardt import minimise, minimise_fully
from identify.fitting.problem import Problem
from identify.fitting.segments import segments_of
from identify.free_decay import FreeDecay
from identify.model.model import Model
from identify.model.simulate import Response
from identify.preprocessing.fit_window import FitWindow
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.signal.oscillation import running_amplitude

STIFFNESS_VARIES = 0.01
"""Relative standard deviation by which the linear spring may differ from one release to the next."""

DAMPING_VARIES = 1.0
"""The same for viscous damping, in units of the mean loss of the release: brakes are set, air and bearings change."""

_GROWTH = (6.0, 20.0)
"""Cycles to which the start is fitted before it is fitted to all."""

_DRAWN_IN = (1.0, 0.98, 0.95, 0.9, 0.8)
_ROUNDS = 3
_PRIOR = "prior"


@dataclass(frozen=True)
class Prediction:
    """What held physics leaves of one release, its start, zero, lag, gain and offsets refitted.

    `motion_percent` is the misfit of the free run in % of the rms of the displacement (or the first channel there is),
    `chi_square` reduced, in units of the noise; both inf where the run diverges. `values` has what was used, by
    unknown's name; `varied` by how much the linear spring and damper differ from what was given, by name, in % of the
    squared frequency and of the mean loss of the release.
    """

    motion_percent: float
    chi_square: float
    values: dict[str, float]
    varied: dict[str, float]


@dataclass(frozen=True, eq=False)
class _Prior:
    """Where an unknown is expected, what it is compared with as a whole, and the share of that by which it varies."""

    at: int
    mean: float
    whole: float
    share: float


class _Problem(Problem):
    """A problem in which some shared unknowns are expected near a value.

    What they are off, in standard deviations times `weight`, is read beside the first window as if it were a channel.
    """

    priors: tuple[_Prior, ...] = ()
    weight = 1.0

    def read(self, theta: Array, i: int, response: Response) -> dict[str, Array]:
        predicted = super().read(theta, i, response)
        if i == 0 and self.priors:
            off = [(theta[prior.at] - prior.mean) / (prior.share * prior.whole) for prior in self.priors]
            predicted[_PRIOR] = self.weight * np.array(off)
        return predicted

    def residual_of(self, i: int, predicted: dict[str, Array]) -> Array:
        readings = super().residual_of(i, predicted)
        return np.concatenate([readings, predicted[_PRIOR]]) if _PRIOR in predicted else readings


def predict(
    model: Model,
    values: Mapping[str, float | Estimate],
    decay: FreeDecay | PreparedDecay | Sequence[PreparedDecay],
    *,
    hold: bool = False,
) -> Prediction:
    """Return what a model with its values foretells of one release; long ones in the segments that a fit sees.

    A long one may be given as its segments.

    `values` are the parameters of its effects by "effect.parameter". They are held; only what the release has of its own
    is refitted: the state at its start, zero, lag, gain and offsets, faults of its sensors. The linear spring and the
    viscous damping may differ, as rigs do, within priors of 1 % and of 100 % of the mean loss, unless `hold`. A prior
    counts in units of what the model leaves, not of the noise, so that a wrong model cannot bend them at will. Raises
    NotIdentifiable when the release holds too little, ValueError where a force has no value.
    """
    missing = [
        str(t.parameter(p.name))
        for t in model.forces
        for p in t.free
        if str(t.parameter(p.name)) not in values
    ]
    if missing:
        raise ValueError(f"no value is given for {', '.join(missing)}")
    pieces = segments_of(decay)
    known = {name: v.value if isinstance(v, Estimate) else float(v) for name, v in values.items()}
    start = known | initial_values(pieces, model, known) | known | _faults(model, known, len(pieces))
    windows = tuple(piece.window for piece in pieces)
    return predict_windows(model, known, windows, start, pieces[0].frequency, hold=hold)


def predict_windows(
    model: Model,
    held: Mapping[str, float],
    windows: tuple[FitWindow, ...],
    start: Mapping[str, float],
    frequency: float,
    *,
    hold: bool = True,
) -> Prediction:
    """Return what `held` values foretell of the windows of one release; arguments as `predict`.

    `start` are values of all unknowns by name, as they are called in a fit of these windows alone; the motion has an
    angular `frequency` (rad/s).
    """
    problem = _Problem(model, windows, frequency)
    theta = np.clip(problem.theta(dict(start) | dict(held)), problem.low, problem.high)
    still = np.array([u.window < 0 and u.name in held for u in problem.unknowns])
    theta = _grown(model, windows, frequency, _bounded(problem, theta), still)
    theta = minimise_fully(problem, theta, held=still).theta
    priors = () if hold else _priors(problem, model, held)
    if priors:
        still[[prior.at for prior in priors]] = False
        problem.priors = priors
        for _ in range(_ROUNDS):
            problem.weight = float(np.sqrt(_scatter(problem, theta)))
            theta = minimise_fully(problem, theta, held=still).theta
    free = int((~still).sum()) - len(priors)
    motion, chi_square = _errors(problem, theta, free)
    varied = {
        problem.unknowns[prior.at].name: 100.0 * float(theta[prior.at] - prior.mean) / prior.whole
        for prior in priors
    }
    named = {u.name: float(value) for u, value in zip(problem.unknowns, theta, strict=True)}
    return Prediction(motion, chi_square, named, varied)


def _faults(model: Model, known: Mapping[str, float], count: int) -> dict[str, float]:
    """Return where faults of sensors, which every release has of its own, begin."""
    start: dict[str, float] = {}
    for term in model.faults:
        for parameter in term.free:
            id = term.parameter(parameter.name)
            value = known.get(str(id), known.get(str(term.parameter(parameter.name, 0))))
            if value is not None:
                start |= {str(id.of_release(i, count)): value for i in range(count)}
    return start


def _bounded(problem: Problem, theta: Array) -> Array:
    """Return the unknowns with the starts drawn in where the motion runs away from where it was measured to begin."""
    starts = [at for places in problem.layout.releases for at in places.start]
    for share in _DRAWN_IN:
        tried = theta.copy()
        tried[starts] *= share
        if np.isfinite(problem.residuals(tried)).all():
            return tried
    return theta


def _grown(
    model: Model, windows: tuple[FitWindow, ...], frequency: float, theta: Array, still: Mask
) -> Array:
    """Return the unknowns with the start fitted to the first cycles, then to more."""
    longest = max(len(window) for window in windows)
    for cycles in _GROWTH:
        samples = int(cycles * 2.0 * np.pi / frequency * windows[0].rate)
        if samples < longest:
            short = Problem(model, tuple(w.until(min(samples, len(w))) for w in windows), frequency)
            theta = minimise(short, theta, steps=10, tolerance=1.0, held=still).theta
    return theta


def _priors(problem: _Problem, model: Model, held: Mapping[str, float]) -> tuple[_Prior, ...]:
    """Return where the linear spring and damper are expected."""
    loss = np.mean([_loss(window, problem.frequency) for window in problem.windows])
    wholes = (
        (LinearPart.STIFFNESS, problem.frequency**2, STIFFNESS_VARIES),
        (LinearPart.DAMPING, float(loss), DAMPING_VARIES),
    )
    found = []
    for part, whole, share in wholes:
        name = model.linear_strength(part)
        if name is not None and str(name) in held and whole > 0.0:
            found.append(_Prior(problem.index[str(name)], held[str(name)], whole, share))
    return tuple(found)


def _loss(window: FitWindow, frequency: float) -> float:
    """Return the mean loss of a window as an equivalent viscous damping, 1/s: -2 d(ln A)/dt over all cycles."""
    channel = window.channels[0]
    used, values = window.used[channel], window.readings[channel]
    period = max(int(2.0 * np.pi / frequency * window.rate), 2)
    if len(values) <= 3 * period or not used.any():
        return 0.0
    running = running_amplitude(np.where(used, values, np.mean(values[used])), period)
    first, last = float(running[period]), float(running[-period - 1])
    if not 0.0 < last < first:
        return 0.0
    return 2.0 * math.log(first / last) * window.rate / (len(values) - 2 * period)


def _scatter(problem: Problem, theta: Array) -> float:
    """Return the variance that a reading counts with, in units of the noise.

    1 where the model is right; what it leaves beyond the noise repeats in every reading of a half-cycle.
    """
    off = np.concatenate(_residuals(problem, theta))
    if not np.isfinite(off).all():
        return 1.0
    half_cycle = np.pi / problem.frequency * problem.windows[0].rate
    return 1.0 + max(float(np.mean(off**2)) - 1.0, 0.0) * half_cycle


def _residuals(problem: Problem, theta: Array) -> Sequence[Array]:
    windows = range(len(problem.windows))
    return [
        Problem.residual_of(problem, i, problem.read(theta, i, problem.respond(theta, i))) for i in windows
    ]


def _errors(problem: Problem, theta: Array, free: int) -> tuple[float, float]:
    """Return the misfit of the motion in % of its rms, and the reduced chi-square; `free` unknowns were refitted."""
    misfit, reading, off = [], [], []
    for i, window in enumerate(problem.windows):
        predicted = problem.read(theta, i, problem.respond(theta, i))
        channel = window.channels[0]
        used = window.used[channel]
        misfit.append((window.readings[channel] - predicted[channel])[used])
        reading.append(window.readings[channel][used])
        off.append(Problem.residual_of(problem, i, predicted))
    left, seen, noise = (np.concatenate(parts) for parts in (misfit, reading, off))
    if not np.isfinite(noise).all():
        return float("inf"), float("inf")
    motion = 100.0 * float(np.sqrt(np.mean(left**2)) / np.std(seen))
    return motion, float(noise @ noise) / max(len(noise) - free, 1)
