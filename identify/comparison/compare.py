"""Compare: by how much a fitted model fails, and where, in units of the noise."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from identify.arrays import Array, Mask, frozen
from identify.comparison.compare_cycles import CycleErrors, compare_cycles
from identify.comparison.discrepancies import NONE, Discrepancy, find_discrepancies
from identify.comparison.discrepancy_text import DiscrepancyText
from identify.comparison.multiple_shooting import MultipleShooting, delayed, rows_of, shoot
from identify.comparison.phase_plane import PhasePlane, compare_phase_plane
from identify.comparison.residual_tone import ResidualTone, find_residual_tone
from identify.errors import NotIdentifiable
from identify.fitting.baseline import Baseline, fit_baseline
from identify.fitting.corrected_faults import corrected_faults
from identify.fitting.fit import Fit
from identify.fitting.model_error import (
    force_floor_percent,
    force_misfit,
    force_mse_percent,
    motion_percent,
)
from identify.fitting.problem import Problem
from identify.formatting import quantity, three_figures
from identify.free_decay import FreeDecay
from identify.model.model import Model, Term, base_model
from identify.model.parameter_id import nuisance
from identify.preprocessing.fit_window import FitWindow
from identify.preprocessing.noise import Noise
from identify.preprocessing.prepared_decay import PreparedDecay, prepare
from identify.residual import floor_words, times
from identify.signal.smoothing import without_line
from identify.summary import Summarised, Summary

_SURE = 4.0
_NEAR_REVERSAL = 4

_NO_SPRING = 1e-6
"""Share of the squared frequency below which a fit has lost its spring."""


@dataclass(frozen=True)
class KinematicCheck:
    """The disagreement of the channels, each in standard errors of the noise.

    `significance` is by how much the misfit of both to one motion exceeds it, a steady drift of their zeros left out;
    `drift` is the size of that drift of the acceleration's zero, which no force can cause.
    """

    significance: float
    drift: float


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Summarised):
    """The places where a model fails on one release, and by how much.

    `force_error` is eq. (18) in %: 100/(n var f) sum (f - f')^2, with f the measured acceleration (less any recorded
    force) and f' the model's force at the measured motion, and `force_floor` what noise alone leaves of it.
    `motion_error` is the rms misfit of the free run over the rms of the first channel, in %, over
    `horizon_cycles`. `chi_square` is reduced, 1.0 when nothing is left to explain, with the standard error
    `chi_square_std` of an adequate model's; `at_floor` says whether it is one. `floor` is the noise of each channel and
    its source.
    `free_run_misfit` (cycles,) is the rms misfit of the free run in units of the noise, cycle by cycle. `places` are the
    worst ones; `summary` is the first in a sentence, `cause` says whether to look at a sensor or at physics.
    """

    force_error: float
    force_floor: float
    motion_error: float
    horizon_cycles: float
    chi_square: float
    chi_square_std: float
    at_floor: bool
    floor: Mapping[str, Noise]
    cycles: CycleErrors
    free_run_misfit: Array
    phase_plane: PhasePlane
    kinematics: KinematicCheck | None
    places: tuple[Discrepancy, ...]
    summary: str
    cause: str
    unit: str
    mass: float | None

    def brief(self) -> Summary:
        """Return the errors, whether a sensor or physics is to blame, and the worst places."""
        title = (
            "The model reaches the noise floor"
            if self.at_floor
            else "The model does not reach the noise floor"
        )
        places = [f"- {place.text} ({place.significance:.0f} standard errors)" for place in self.places]
        rows = (
            ("force, mean square %", three_figures(self.force_error), three_figures(self.force_floor)),
            ("motion, rms %", three_figures(self.motion_error), "-"),
            ("motion, times the noise", times(self.chi_square), floor_words(self.chi_square_std)),
        )
        return Summary(title, (self.cause, *places), ("error", "value", "at the floor"), rows)


def compare(decay: FreeDecay | PreparedDecay, model: Model | None = None) -> Comparison:
    """Fit a model (stiffness, Coulomb and viscous friction unless given) to one release, and compare the two.

    Forces are given in N where the release states its mass. Raises NotIdentifiable when the release holds too little to
    fit anything.
    """
    prepared = prepare(decay) if isinstance(decay, FreeDecay) else decay
    return compare_fitted(fit_baseline((prepared,), model or base_model()))


def compare_fitted(baseline: Baseline) -> Comparison:
    """Compare a model that was fitted to one release with the measurement."""
    prepared, fit, floor = baseline.decays[0], baseline.fit, baseline.floors[0]
    window = fit.windows[0]
    doubt = max((n.uncertainty / n.std for n in floor.channels.values() if n.std > 0), default=0.0)
    faults = fit.model.faults if baseline.at_floor else ()
    seen = without_faults(prepared, fit) if faults else (prepared, fit)
    shooting = shoot(*seen)
    if shooting.stiffness < _NO_SPRING * fit.frequency**2:
        raise NotIdentifiable(
            "The model, fitted to this record in one run, has lost its spring: it cannot be compared cycle by cycle. "
            "Is the motion driven?"
        )
    cycles = compare_cycles(shooting)
    plane = compare_phase_plane(shooting)
    kinematics = _checked_kinematics(prepared, window, doubt)
    factors = tuple(
        (1.0 + doubt) * max(1.0, np.sqrt(left)) for left in (plane.chi_square_after, cycles.chi_square_after)
    )
    tone = find_residual_tone(shooting)
    text = DiscrepancyText(window.unit, prepared.mass)
    places = find_discrepancies(plane, cycles, tone, text, (factors[0], factors[1]))
    measured, residual = force_misfit(*seen)
    return Comparison(
        force_error=force_mse_percent(seen[0], measured, residual),
        force_floor=force_floor_percent(seen[0], measured),
        motion_error=motion_percent(fit),
        horizon_cycles=len(window) / window.rate * fit.frequency / (2.0 * np.pi),
        chi_square=baseline.reduced(fit),
        chi_square_std=baseline.spread,
        at_floor=baseline.at_floor,
        floor=floor.channels,
        cycles=cycles,
        free_run_misfit=_misfit_by_cycle(fit, shooting),
        phase_plane=plane,
        kinematics=kinematics,
        places=places,
        summary=NONE if not places else f"{places[0].text[0].upper()}{places[0].text[1:]}.",
        cause=_cause(baseline, faults, kinematics, tone),
        unit=window.unit,
        mass=prepared.mass,
    )


def without_faults(prepared: PreparedDecay, fit: Fit) -> tuple[PreparedDecay, Fit]:
    """Return a release and a fit that explains it as sensors without the modelled faults would have read them.

    The measured motion and alignment have the faults in them, which would be taken for forces: the model's take their place.
    """
    values, window, motion = fit.of_release(0), fit.windows[0], prepared.motion
    problem = Problem(Model(fit.model.forces), (window,), fit.frequency)
    theta = problem.theta(values)
    read = problem.read(theta, 0, problem.respond(theta, 0))
    response = problem.respond(problem.theta(values | {str(nuisance("lag", 0, 1)): 0.0}), 0)
    zero = prepared.zero - values.get("displacement_offset", prepared.zero)
    motion = replace(
        motion,
        displacement=response.displacement - zero,
        velocity=response.velocity,
        acceleration=response.acceleration,
    )
    aligned = prepared.alignment
    if aligned is not None:
        lag, gain = (fit.nuisance(name, 0) or getattr(aligned, name) for name in ("lag", "gain"))
        aligned = replace(aligned, lag=lag, gain=gain)
    readings = {c: fit.residual(c) + read[c] for c in window.channels}
    seen = replace(fit, windows=(window.with_(readings=readings),), predicted=(read,))
    return replace(prepared, motion=motion, alignment=aligned), seen


def _misfit_by_cycle(fit: Fit, shooting: MultipleShooting) -> Array:
    window = fit.windows[0]
    misfit = []
    for segment in shooting.segments:
        part = slice(segment.start, segment.stop)
        rows = rows_of(window, part, {c: fit.residual(c)[part] for c in window.channels})
        misfit.append(float(np.sqrt(np.mean(rows**2))) if len(rows) else np.nan)
    return frozen(misfit)


def _checked_kinematics(
    prepared: PreparedDecay, window: FitWindow, floor_error: float
) -> KinematicCheck | None:
    """Compare both channels with the one motion that suits them best; None with a single channel.

    `floor_error` is the relative standard error of the noise floor.
    """
    aligned, motion = prepared.alignment, prepared.motion
    if aligned is None:
        return None
    low = window.channels[0]
    noise = window.sigma["acceleration"] / abs(aligned.gain.value)
    read = delayed(motion.displacement, motion.velocity, motion.acceleration, aligned.lag.value, window.rate)
    left = window.readings[low] - read[0 if low == "displacement" else 1]
    inside = motion.valid & window.used["acceleration"] & window.used[low] & ~_near_reversals(motion.velocity)
    if not inside.any():  # of few readings a cycle all are near a reversal, and contradict nothing
        return KinematicCheck(0.0, 0.0)
    uneven = window.readings["acceleration"] / aligned.gain.value - motion.acceleration
    high, left = without_line(uneven, inside), without_line(left, inside)
    total = float(np.sum((high[inside] / noise) ** 2) + np.sum((left[inside] / window.sigma[low]) ** 2))
    degrees = max(int(inside.sum()) - 6, 1)
    line = (uneven - high)[inside]
    return KinematicCheck(
        (total / degrees - 1.0) / float(np.hypot(np.sqrt(2.0 / degrees), 2.0 * floor_error)),
        float(np.linalg.norm(line - line.mean())) / noise,
    )


def _near_reversals(velocity: Array) -> Mask:
    """Where dry friction turns around between two samples, and a smooth motion cannot follow, shape (n,)."""
    turns = np.zeros(len(velocity), dtype=bool)
    turns[:-1] = np.signbit(velocity[1:]) != np.signbit(velocity[:-1])
    return np.convolve(turns, np.ones(2 * _NEAR_REVERSAL + 1), "same") > 0.5


def _cause(
    baseline: Baseline,
    modelled: tuple[Term, ...],
    kinematics: KinematicCheck | None,
    tone: ResidualTone | None,
) -> str:
    """Say whether to look at a sensor or at physics; faults that are `modelled` explain what they do to the channels."""
    if kinematics is None:
        return (
            "Without an acceleration beside a displacement or velocity, a fault of a sensor cannot be distinguished from "
            "physics."
        )
    if tone is not None and tone.sensor:
        return (
            f"At {quantity(tone.frequency)} the {tone.channel} shows what the other channel does not: hum or a disturbance "
            "of that sensor; look at it first."
        )
    if kinematics.significance > _SURE and not modelled:
        return (
            f"The channels contradict each other, whatever the forces are (a - D^2 u is {kinematics.significance:.0f} "
            "standard errors above its noise): look at a sensor first."
        )
    if kinematics.drift > _SURE and not modelled:
        return "The zero of the acceleration moves during the record, which no force can do: look at that sensor first."
    if not baseline.adequate(baseline.fit):
        return (
            "Both channels describe one motion within their noise, and the model does not follow it: "
            "the cause is physics (or the displacement drifts slowly, which looks like motion)."
        )
    faults = [f.term for f in corrected_faults(baseline.decays, baseline.fit) if f.p_value < baseline.alpha]
    if faults := [*modelled, *faults]:
        return (
            f"The model follows the motion once a sensor's fault is corrected ({faults[0].effect.title}): "
            "look at that sensor."
        )
    return "Both channels describe one motion within their noise, and the model follows it within its noise."
