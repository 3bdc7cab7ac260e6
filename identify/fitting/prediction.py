"""Prediction of a release by a model that was not fitted to it, its physics held."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from identify.estimate import Estimate
from identify.fitting.fit import fit
from identify.fitting.initial_values import initial_nuisances
from identify.fitting.own_linear import own_springs, percent_off, weighed, with_own_linear, without_own_linear
from identify.fitting.parameter_layout import NOWHERE
from identify.fitting.problem import Problem
from identify.fitting.segments import segments_of
from identify.free_decay import FreeDecay
from identify.model.model import Model
from identify.preprocessing.fit_window import FitWindow
from identify.preprocessing.prepared_decay import PreparedDecay


@dataclass(frozen=True)
class Prediction:
    """The residual of one release under held physics, with its start, zero, lag, gain and offsets refitted.

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
    """Predict one release by a model with its values; a long one in the segments that a fit uses.

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
        if not p.of_release and str(t.parameter(p.name)) not in values
    ]
    if missing:
        raise ValueError(f"no value is given for {', '.join(missing)}")
    pieces = segments_of(decay)
    known = {name: v.value if isinstance(v, Estimate) else float(v) for name, v in values.items()}
    own = _own_values(model, known, len(pieces))
    start = initial_nuisances(pieces, model, known | own) | known | own
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
    """Predict the windows of one release by `held` values; arguments as `predict`.

    `start` are values of all unknowns by name, as they are called in a fit of these windows alone; the motion has an
    angular `frequency` (rad/s). Spring and damper may differ where the windows say so.
    """
    bare = without_own_linear(windows)
    own = Problem(model, windows, frequency)
    still = frozenset(u.name for u in own.unknowns if u.window < 0 and u.name in held)
    found = fit(model, bare, dict(start) | dict(held), frequency, held=still)
    if own.expected:
        again = weighed(own, own.theta(found.point))
        found = fit(model, again, found.point, frequency, near=True, held=still)
    off = {}
    for unknown in found.unknowns:
        if unknown.deviates != NOWHERE:
            name = found.unknowns[unknown.deviates].name
            off[name] = percent_off(found.windows[unknown.window], unknown, found.point[name] - held[name])
    channel, runs_away = windows[0].channels[0], not np.isfinite(found.chi_square)
    used = np.concatenate([window.used[channel] for window in windows])
    seen = np.concatenate([window.readings[channel] for window in windows])[used]
    left = np.concatenate([found.residual(channel, i) for i in range(len(windows))])[used]
    physics = found.problem.within(found.theta, 0).tolist()
    return Prediction(
        np.inf if runs_away else 100.0 * float(np.sqrt(np.mean(left**2)) / np.std(seen)),
        found.reduced,
        {u.name: value for u, value in zip(found.unknowns, physics, strict=True) if u.deviates == NOWHERE},
        off,
    )


def _own_values(model: Model, known: Mapping[str, float], count: int) -> dict[str, float]:
    """Return starting values of what each release has of its own: faults of sensors, and phases of shaking."""
    start: dict[str, float] = {}
    for term in model.terms:
        for parameter in (p for p in term.free if p.of_release or not term.is_force):
            id = term.parameter(parameter.name)
            value = known.get(str(id), known.get(str(term.parameter(parameter.name, 0))))
            if term.is_force:
                start[str(id)] = value or 0.0
            elif value is not None:
                start |= {str(id.of_release(i, count)): value for i in range(count)}
    return start
