"""Whether the identified model explains its own record: this decides whether its values may be quoted."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from math import hypot

from daq.clock_check import CLOCK_LIMIT
from daq.manifest import Manifest
from daq.quality import Grade
from daq.reading_flags import Flag
from identify.effects.library import DAMPING_BY_ORDER, STIFFNESS_BY_ORDER
from identify.estimate import Estimate
from identify.fitting.baseline import fit_baseline
from identify.fitting.fit import Fit
from identify.fitting.model_error import ModelError, errors_of, is_negligible, may_hide_anything
from identify.fitting.segments import segments_of
from identify.formatting import damping_name, stiffness_name, two_figures
from identify.model.model import model_of_orders
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.residual import floor_words, residual_words
from identify.restoring_force.restoring_force import RestoringForceResult
from identify.wavelet.wavelet import WaveletResult

Method = WaveletResult | RestoringForceResult

_NAMES = {effect.name: stiffness_name(order) for order, effect in STIFFNESS_BY_ORDER.items()} | {
    effect.name: damping_name(order) for order, effect in enumerate(DAMPING_BY_ORDER)
}
"""The name of the strength of an effect among the estimates of a method."""

FAR_APART = 4.0
"""Standard errors from which on two estimates disagree."""

_NEGATIVE = 3.0
"""Standard errors below zero from which on a dry friction is not one."""

GAIN_WORTH_SAYING = 2e-3
"""Relative difference of the channels' gains below which nothing is said of it."""


@dataclass(frozen=True, eq=False)
class Adequacy:
    """The identified model fitted to its own record and simulated from the release, with its errors.

    `adequate` says whether the noise floor is reached or, where it is a guess, the residual is negligible. `apart` is the
    parameter in which two of the estimates (by the methods, by the simulation) are farthest apart, with the distance in
    standard errors `sigmas`. `doubt` is what its clock, its noise, the sign of its friction, or the verdict on the
    recording holds against every value; "" for nothing. `negligible` says that the floor is not reached, and need not be.
    """

    fit: Fit
    error: ModelError
    adequate: bool
    apart: str = ""
    sigmas: float = 0.0
    doubt: str = ""
    negligible: bool = False

    @property
    def effects(self) -> tuple[str, ...]:
        """The names of the effects in the model."""
        return self.fit.model.names

    @property
    def quotable(self) -> bool:
        """Whether the values may be quoted: the recording is sound, the model explains it, and the estimates agree."""
        return not self.doubt and self.adequate and self.sigmas <= FAR_APART


def needed_orders(methods: Sequence[Method]) -> tuple[int, tuple[int, ...]]:
    """Return the order of damping and the orders of stiffness that either method needs."""
    stiffness = {
        order
        for method in methods
        for order, value in method.stiffness_by_order.items()
        if order == 1 or abs(value.value) > FAR_APART * value.std
    }
    return max(method.order for method in methods), tuple(sorted(stiffness | {1}))


def recording_doubt(manifest: Manifest | None) -> str:
    """Decide what the verdict holds against every value of a recording: a REJECT, or a sensor's fault; "" for nothing."""
    if manifest is None:
        return ""
    verdict = manifest.verdict
    if verdict is not None and verdict.grade is Grade.REJECT:
        return f"the recording is {verdict.grade.value} ({verdict.reasons[0]})"
    # A blow may saturate: what follows it is sound.
    faults = dict.fromkeys(
        f"{run.channel}: {run.flag}" for run in manifest.flags if run.flag != Flag.SATURATED
    )
    return f"a sensor failed during the record ({', '.join(faults)})" if faults else ""


def adequacy(prepared: PreparedDecay, methods: Sequence[Method], doubt: str = "") -> Adequacy:
    """Fit the model that the methods identified to its record and judge its residual; compare them with each other.

    `doubt` is what the verdict on the recording holds against its values.
    """
    baseline = fit_baseline(segments_of(prepared), model_of_orders(*needed_orders(methods)))
    off = (prepared.window.rate_std or 0.0) / prepared.window.rate
    of_clock = "" if off <= CLOCK_LIMIT else f"the sampling rate may be off by {100.0 * off:.2g} %"
    guessed = "the noise is only a guess, and any model would pass"
    of_noise = guessed if may_hide_anything(baseline, baseline.fit) else ""
    fit, error = baseline.stated(baseline.fit), errors_of(baseline)
    names = ["wavelet" if isinstance(method, WaveletResult) else "restoring force" for method in methods]
    estimates = dict(zip(names, map(_per_mass, methods), strict=True))
    estimates["simulation"] = {
        _NAMES[term.effect.name]: fit.parameters[str(term.strength)] for term in fit.model.forces
    }
    apart, sigmas = farthest(estimates)
    negative = any(method.damping[0].value < -_NEGATIVE * method.damping[0].std for method in methods)
    of_law = "its dry friction is below zero, so another law of damping must be at work" if negative else ""
    little = not baseline.at_floor and is_negligible(baseline)
    doubts = doubt or of_clock or of_noise or of_law
    return Adequacy(fit, error, baseline.at_floor or little, apart, sigmas, doubts, negligible=little)


def _per_mass(method: Method) -> dict[str, Estimate]:
    """Return the estimates of a method by name, without a mass, whose error all estimates would share."""
    first, per_mass = next(iter(method.stiffness_by_order)), method.stiffness_per_mass
    mass = method.stiffness.value / per_mass.value
    springs = {
        stiffness_name(order): replace(k, value=k.value / mass, std=k.std / mass)
        for order, k in method.stiffness_by_order.items()
    }
    return method.parameters | springs | {stiffness_name(first): per_mass}


def farthest(estimates: dict[str, dict[str, Estimate]]) -> tuple[str, float]:
    """Find the parameter in which two sets of estimates differ most, in words, and by how many standard errors.

    `estimates` are by the name of the way in which they were made, and by the name of the parameter.
    """
    pairs = [
        (sigmas_apart(estimates[one][name], estimates[other][name]), f"{name} by {one} and by {other}")
        for one, other in combinations(estimates, 2)
        for name in estimates[one].keys() & estimates[other].keys()
    ]
    sigmas, words = max(pairs)
    return words, sigmas


def sigmas_apart(first: Estimate, other: Estimate) -> float:
    """Count the joint standard errors between two estimates; 0 where these are not known."""
    error = hypot(first.std, other.std)
    return abs(first.value - other.value) / error if 0.0 < error < float("inf") else 0.0


def judgement(found: Adequacy) -> str:
    """Say whether the values may be quoted."""
    error = found.error
    left = residual_words(error.motion_percent, error.chi_square, None if found.adequate else error.floor_std)
    words = f"the identified model leaves {left} (noise alone: {floor_words(error.floor_std)})"
    if found.negligible:
        words = f"{words}, too little to name an effect by"
    if found.quotable:
        return f"{words}: its values may be quoted"
    apart = f"{found.apart} are {found.sigmas:.0f} standard errors apart"
    why = "" if not found.adequate else f", but {found.doubt or apart}"
    return f"{words}{why}: do not quote its values"


def scale_doubt(gain: Estimate) -> str:
    """Say how uncertain forces are because the gains of the two channels differ; "" where they agree, but for a sign."""
    off = abs(abs(gain.value) - 1.0)
    if off <= max(FAR_APART * gain.std, GAIN_WORTH_SAYING):
        return ""
    return (
        f"The gains of the channels differ by {two_figures(100.0 * off)} %: every force is uncertain by as much until both "
        "sensors are calibrated against one reference."
    )
