"""The three errors of a model: of the force, of the simulated motion, and relative to the noise floor."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from identify.arrays import Array
from identify.fitting.baseline import Baseline
from identify.fitting.fit import Fit
from identify.model.measured_path import model_force
from identify.model.model import Term
from identify.preprocessing.equation_error import moving
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.priors import ADEQUATE, HARDLY_KNOWN, LARGE, NEGLIGIBLE


@dataclass(frozen=True)
class ModelError:
    """The errors of a model against the measurement.

    `force_mse_percent` is eq. (18) on the measured acceleration, `motion_percent` the free-run misfit of the
    displacement (or the first channel there is) in percent of its rms over `horizon_s`, `chi_square` the reduced
    chi-square, 1.0 when nothing is left to explain, and `floor_std` its standard error for an adequate model.
    """

    force_mse_percent: float
    motion_percent: float
    horizon_s: float
    chi_square: float
    floor_std: float


def force_misfit(prepared: PreparedDecay, fit: Fit, i: int = 0) -> tuple[Array, Array]:
    """Return the measured restoring force per unit mass along the motion, and a model's residual of it, (n,)."""
    window, motion = fit.windows[i], prepared.motion
    values = fit.of_release(i) | fit.problem.states_at_start(fit.theta, i)
    u = motion.displacement + prepared.zero - values.get("displacement_offset", prepared.zero)
    measured = prepared.restoring
    if window.estimates_mass and window.force is not None:
        measured = measured + (values["force_gain"] - 1.0) * window.force
    return measured, measured - model_force(fit.model, values, window.clock, u, motion.velocity)


def force_mse_percent(prepared: PreparedDecay, measured: Array, residual: Array) -> float:
    """Return eq. (18) in % over the samples that move: 100/(n var f) sum (f - f')^2."""
    used = moving(prepared.motion)
    return float(100.0 * np.mean(residual[used] ** 2) / np.var(measured[used]))


def force_floor_percent(prepared: PreparedDecay, measured: Array) -> float:
    """Return what noise alone leaves of the same mean square, in %."""
    noise = prepared.motion.noise_acceleration or 0.0
    return 100.0 * noise**2 / float(np.var(measured[moving(prepared.motion)]))


def motion_percent(fit: Fit, place: int = 0) -> float:
    """Return the free-run misfit of the displacement (or the first channel there is) in % of its rms, over all releases.

    Both about their means. Another `place` chooses another channel, of releases with so many.
    """

    def left(channel: str, i: int) -> float:
        return float(np.mean(fit.left(channel, i)[fit.windows[i].used[channel]] ** 2))

    return _percent_of_motion(fit, left, place)


def noise_percent(fit: Fit) -> float:
    """Return what noise alone leaves of the same, in %; of coloured noise as much as in this residual."""
    return _percent_of_motion(fit, lambda channel, i: fit.noise(channel, i) ** 2)


def _percent_of_motion(fit: Fit, mean_square: Callable[[str, int], float], place: int = 0) -> float:
    shares = []
    for i, window in enumerate(fit.windows):
        channel = window.channels[min(place, len(window.channels) - 1)]
        shares.append(mean_square(channel, i) / np.var(window.readings[channel][window.used[channel]]))
    return 100.0 * float(np.sqrt(np.mean(shares)))


def may_hide_anything(baseline: Baseline, found: Fit) -> bool:
    """Check whether a fit leaves enough of the motion for a name, and only a floor that is hardly known accepts it.

    A guess far above all that a fit leaves is no better known.
    """
    too_high = found.reduced < float(np.exp(-ADEQUATE * baseline.spread))
    unknown = not baseline.floor_is_sure and (too_high or baseline.spread >= HARDLY_KNOWN)
    return unknown and baseline.adequate(found) and motion_percent(found) > LARGE


def is_negligible(baseline: Baseline) -> bool:
    """Check whether a fitted model leaves too little of the motion to be missing anything, above a floor that is a guess."""
    return not baseline.floor_is_sure and motion_percent(baseline.fit) < NEGLIGIBLE


def removed_percent(before: Fit, after: Fit) -> float:
    """Return the part of the first fit's misfit that the second removes, in % of the rms motion; 0 where it adds some."""
    return float(np.sqrt(max(motion_percent(before) ** 2 - motion_percent(after) ** 2, 0.0)))


def line_percent(fit: Fit, term: Term) -> float:
    """Return the rms of a sensor's line in % of the rms of its channel's motion, the largest of all releases."""
    name, shares = term.effect.strength.name, [0.0]
    for i, window in enumerate(fit.windows):
        if term.channel in window.channels:
            motion = float(np.std(window.readings[term.channel][window.used[term.channel]]))
            shares.append(abs(fit.of(term, i)[name].value) / (np.sqrt(2.0) * max(motion, 1e-300)))
    return 100.0 * float(max(shares))


def errors_of(start: Baseline) -> ModelError:
    """Return the errors of a fitted model, over all its releases."""
    force = [
        force_mse_percent(prepared, *force_misfit(prepared, start.fit, i))
        for i, prepared in enumerate(start.decays)
    ]
    return ModelError(
        float(np.mean(force)),
        motion_percent(start.fit),
        max(len(window) / window.rate for window in start.fit.windows),
        start.reduced(start.fit),
        start.spread,
    )
