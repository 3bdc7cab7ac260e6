"""Whether releases share their physics: the usual model fitted to each alone, with errors that include its misfit.

A joint diagnosis begins from the assumption that stiffness and friction are the same in every release. This looks at it
in a fraction of a second, before anything is searched for.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from identify.effects.force_effect import LinearPart
from identify.estimate import Estimate
from identify.fitting.fit import Fit, fit
from identify.fitting.initial_values import initial_values
from identify.fitting.segments import part_of, segments_of
from identify.formatting import three_figures
from identify.model.model import Model, base_model
from identify.preprocessing.prepared_decay import PreparedDecay

DIFFERENT = 4.0
"""Standard errors from which on two releases differ in a parameter."""

WORTH_SAYING = 1e-3
"""Relative difference below which nothing is said, however sure it is."""

OTHER_BENCH = 2.0
"""Factor between two stiffnesses per mass from which on the benches are plainly different ones."""

_MISFIT = 0.1
"""Share of the difference between the halves of a decay that counts as an error at the same amplitude."""

_FEWEST_CYCLES = 2.0
_LEAST_LOG = 0.1
_TOO_FAR_OFF = 0.1
"""Misfit of the motion from which on the usual model's friction says nothing, only its stiffness."""


@dataclass(frozen=True)
class OwnPhysics:
    """The parameters of the usual model on one release alone, by name, per unit mass.

    Each error is the larger of the noise's, scaled by what the fit leaves, and a tenth of the difference between the
    first and the second half of the decay; `per_log_amplitude` is that difference over the logarithm of the ratio of
    their amplitudes, by name: what another amplitude may do to the parameter. `halves` are the smaller and the larger
    stiffness of the two halves and of the whole, 1/s^2. `amplitude` is the largest and `rms` the
    root mean square of the displacement, in `unit`; `misfit` what the fit leaves of the motion, as a share of its rms.
    """

    amplitude: float
    rms: float
    unit: str
    parameters: dict[str, Estimate]
    per_log_amplitude: dict[str, float]
    stiffness: str
    misfit: float
    halves: tuple[float, float]


@dataclass(frozen=True)
class Difference:
    """Release `index` differs from the first in a parameter, which is the `meaning` in words.

    `percent` is of the first's value (inf where that is 0), `sigmas` in standard errors of the difference.
    """

    index: int
    parameter: str
    meaning: str
    first: Estimate
    other: Estimate
    percent: float
    sigmas: float

    def words(self, first: str) -> str:
        """Return a clause, as "stiffness per unit mass 3.1 % lower than release_1 (12 standard errors)"."""
        way = "higher" if self.other.value > self.first.value else "lower"
        if np.isfinite(self.percent):
            size = f"{three_figures(abs(self.percent))} %"
        else:
            size = f"{abs(self.other.value - self.first.value):.3g} {self.first.unit}"
        return f"{self.meaning} {size} {way} than {first} ({three_figures(self.sigmas)} standard errors)"


@dataclass(frozen=True)
class SharedPhysics:
    """The values of each release alone, and the differences of the others from the first."""

    own: tuple[OwnPhysics, ...]
    differences: tuple[Difference, ...]

    @property
    def other_benches(self) -> tuple[int, ...]:
        """The releases whose stiffness is another by so much that they are of another bench.

        However large its error: a factor of two is none of a fit, unless the stiffness drifts as far within a release.
        """
        return tuple(i for i, own in enumerate(self.own) if i and _far(self.own[0], own))


def shared_physics(decays: Sequence[PreparedDecay]) -> SharedPhysics:
    """Compare the physics of releases, by the usual model fitted to each alone.

    Raises NotIdentifiable where a release holds too little to fit anything.
    """
    model = base_model()
    own = tuple(_own_physics(prepared, model) for prepared in decays)
    meanings = {str(term.parameter(p.name)): p.meaning for term in model.terms for p in term.free}
    differences = [
        difference
        for index in range(1, len(own))
        for name in own[0].parameters
        if (difference := _difference(own, index, name, meanings[name])) is not None
    ]
    return SharedPhysics(own, tuple(differences))


def _far(first: OwnPhysics, other: OwnPhysics) -> bool:
    (_, low), (high, _) = sorted((first.halves, other.halves))
    return high > OTHER_BENCH * low


def _difference(own: tuple[OwnPhysics, ...], index: int, name: str, meaning: str) -> Difference | None:
    first, other = own[0].parameters[name], own[index].parameters[name]
    if name != own[0].stiffness and max(own[0].misfit, own[index].misfit) > _TOO_FAR_OFF:
        return None
    off = other.value - first.value
    slope = max(own[0].per_log_amplitude[name], own[index].per_log_amplitude[name])
    by_amplitude = slope * abs(float(np.log(own[0].rms / own[index].rms)))
    error = float(np.sqrt(first.std**2 + other.std**2 + by_amplitude**2))
    if not 0.0 < error < np.inf or abs(off) <= DIFFERENT * error:
        return None
    percent = 100.0 * off / first.value if first.value else float("inf")
    if abs(percent) < 100.0 * WORTH_SAYING:
        return None
    return Difference(index, name, meaning, first, other, percent, abs(off) / error)


def _own_physics(prepared: PreparedDecay, model: Model) -> OwnPhysics:
    whole = _fit_alone(prepared, model)
    halves = _halves(prepared)
    fits = [_fit_alone(half, model) for half in halves]
    stiffness = str(model.linear_strength(LinearPart.STIFFNESS))
    parameters, slopes = {}, {}
    for name, found in whole.parameters.items():
        std, slopes[name] = found.std * np.sqrt(max(whole.reduced, 1.0)), 0.0
        if halves:
            early, late = (half.parameters[name].value for half in fits)
            ratio = abs(float(np.log(_rms(halves[0]) / _rms(halves[1]))))
            std = max(std, _MISFIT * abs(early - late))
            slopes[name] = abs(early - late) / max(ratio, _LEAST_LOG)
        parameters[name] = replace(found, std=float(std))
    rms = _rms(prepared)
    springs = [found.parameters[stiffness].value for found in (whole, *fits)]
    return OwnPhysics(
        prepared.amplitude,
        rms,
        prepared.window.unit,
        parameters,
        slopes,
        stiffness,
        _misfit(whole),
        (min(springs), max(springs)),
    )


def _misfit(found: Fit) -> float:
    left, motion = 0.0, 0.0
    for i, window in enumerate(found.windows):
        channel = window.channels[0]
        used = window.used[channel]
        left += float(np.sum(found.residual(channel, i)[used] ** 2))
        motion += float(
            np.sum((window.readings[channel][used] - np.mean(window.readings[channel][used])) ** 2)
        )
    return float(np.sqrt(left / motion)) if motion > 0.0 else 0.0


def _rms(prepared: PreparedDecay) -> float:
    return float(np.sqrt(np.mean(np.square(prepared.motion.displacement))))


def _fit_alone(prepared: PreparedDecay, model: Model) -> Fit:
    pieces = segments_of(prepared)
    start = initial_values(pieces, model, {})
    return fit(model, tuple(piece.window for piece in pieces), start, prepared.frequency)


def _halves(prepared: PreparedDecay) -> tuple[PreparedDecay, ...]:
    """Return the two halves of a decay, each with a start of its own; none where they hold too few cycles."""
    window = prepared.window
    n = len(window)
    middle = n // 2
    if middle / window.rate * prepared.frequency / (2.0 * np.pi) < _FEWEST_CYCLES:
        return ()
    return tuple(part_of(prepared, slice(first, last)) for first, last in ((0, middle), (middle, n)))
