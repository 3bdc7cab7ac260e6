"""Prediction: what physics that is held predicts of a release that it was not fitted to."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, Mask
from identify.estimate import Estimate
from identify.fitting.initial_values import initial_values
from identify.fitting.levenberg_marquardt import minimise, minimise_fully
from identify.fitting.own_linear import own_springs, percent_off, weighed, with_own_linear, without_own_linear
from identify.fitting.parameter_layout import NOWHERE
from identify.fitting.problem import Problem
from identify.fitting.segments import segments_of
from identify.free_decay import FreeDecay
from identify.model.model import Model
from identify.preprocessing.fit_window import FitWindow
from identify.preprocessing.prepared_decay import PreparedDecay

_GROWTH = (6.0, 20.0)
"""Cycles to which the start is fitted before it is fitted to all."""

_DRAWN_IN = (1.0, 0.98, 0.95, 0.9, 0.8)
_ROUNDS = 3


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


def predict(
    model: Model,
    values: Mapping[str, float | Estimate],
    decay: FreeDecay | PreparedDecay | Sequence[PreparedDecay],
    *,
    hold: bool = False,
) -> Prediction:
    """Return what a model with its values predicts of one release; long ones in the segments that a fit sees.

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
    windows, frequency = tuple(piece.window for piece in pieces), pieces[0].frequency
    windows = without_own_linear(windows) if hold else with_own_linear(windows, frequency)
    start = own_springs(pieces, model, start) | start
    return predict_windows(model, known, windows, start, frequency)


def predict_windows(
    model: Model,
    held: Mapping[str, float],
    windows: tuple[FitWindow, ...],
    start: Mapping[str, float],
    frequency: float,
) -> Prediction:
    """Return what `held` values predict of the windows of one release; arguments as `predict`.

    `start` are values of all unknowns by name, as they are called in a fit of these windows alone; the motion has an
    angular `frequency` (rad/s). Spring and damper may differ where the windows say so.
    """
    bare = without_own_linear(windows)
    problem = Problem(model, bare, frequency)
    theta = np.clip(problem.theta(dict(start) | dict(held)), problem.low, problem.high)
    still = _still(problem, held)
    theta = _grown(model, bare, frequency, _bounded(problem, theta), still)
    theta = minimise_fully(problem, theta, held=still).theta
    problem, theta = _varied(problem, theta, windows, held)
    free = int((~_still(problem, held)).sum()) - len(problem.expected)
    motion, chi_square = _errors(problem, theta, free)
    off = {problem.unknowns[one.shared].name: percent_off(problem, theta, one) for one in problem.expected}
    own = problem.within(theta, 0)
    named = {
        u.name: float(value) for u, value in zip(problem.unknowns, own, strict=True) if u.deviates == NOWHERE
    }
    return Prediction(motion, chi_square, named, off)


def _still(problem: Problem, held: Mapping[str, float]) -> Mask:
    """Return which unknowns are held, (unknowns,): the physics that has values."""
    return np.array([u.window < 0 and u.name in held for u in problem.unknowns])


def _varied(
    problem: Problem, theta: Array, windows: tuple[FitWindow, ...], held: Mapping[str, float]
) -> tuple[Problem, Array]:
    """Return the problem and its unknowns with the spring and damper that the release has of its own, if it may."""
    known = dict(zip(problem.index, theta.tolist(), strict=True))
    problem = Problem(problem.model, windows, problem.frequency)
    theta = problem.theta(known)
    if problem.expected:
        for _ in range(_ROUNDS):
            problem = Problem(problem.model, weighed(problem, theta), problem.frequency)
            theta = minimise_fully(problem, theta, held=_still(problem, held)).theta
    return problem, theta


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


def _errors(problem: Problem, theta: Array, free: int) -> tuple[float, float]:
    """Return the misfit of the motion in % of its rms, and the reduced chi-square; `free` unknowns were refitted."""
    misfit, reading, off = [], [], []
    for i, window in enumerate(problem.windows):
        predicted = problem.read(theta, i, problem.respond(theta, i))
        channel = window.channels[0]
        used = window.used[channel]
        misfit.append((window.readings[channel] - predicted[channel])[used])
        reading.append(window.readings[channel][used])
        off.append(problem.residual_of(i, predicted))
    left, seen, noise = (np.concatenate(parts) for parts in (misfit, reading, off))
    if not np.isfinite(noise).all():
        return float("inf"), float("inf")
    motion = 100.0 * float(np.sqrt(np.mean(left**2)) / np.std(seen))
    return motion, float(noise @ noise) / max(len(noise) - free, 1)
