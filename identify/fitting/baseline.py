"""The baseline: a model fitted to releases, and the noise floor to which its residual is compared."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from identify.arrays import Array
from identify.effects.effect import Scales
from identify.effects.force_effect import LinearPart
from identify.fitting.corrected_faults import FEWEST_LOST, unnamed_faults
from identify.fitting.fit import Fit, fit
from identify.fitting.harmonic_residual import HarmonicResidual, harmonic_residual
from identify.fitting.initial_values import initial_values, regress_model, scales_of
from identify.fitting.misfit_errors import with_misfit_errors
from identify.fitting.noise_colour import ChannelColour, noise_colours
from identify.fitting.own_linear import own_springs
from identify.fitting.random_walk import RandomWalk, walk_beside, with_walk_errors
from identify.model.model import Model
from identify.model.parameter_id import values_in_release
from identify.preprocessing.fit_window import release_numbers
from identify.preprocessing.noise import Noise, stale
from identify.preprocessing.noise_colour import SHORTEST
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.priors import ADEQUATE, BENEFIT_OF_DOUBT, DOUBT, DOUBT_AT_A_GUESS, RIVALS_WITHIN
from identify.signal.spectrum import high_band_floor, strongest_lines

_BAND_ABOVE = 8.0
_DISAGREE = 4.0

_BAND = "band above the motion"


@dataclass(frozen=True)
class Floor:
    """Noise of each channel of one window, and the uncertainty that it gives the reduced chi-square.

    `chi_square_std` is the standard error of a reduced chi-square of an adequate model: from the number of readings
    and from the uncertainty of the noise itself.
    """

    channels: dict[str, Noise]
    chi_square_std: float


def refined_floor(fit: Fit, i: int, known: dict[str, Noise], colours: dict[str, ChannelColour]) -> Floor:
    """Estimate the floor of window i from the noise `known` before and the high band of the fit's residual.

    Two estimates that agree are averaged by their errors. Where the band above the motion lies higher, what the
    model lacks leaks into it, and the estimate from before stands; where it lies lower, it is the floor. Of a channel
    whose noise is coloured (`colours`) that is the floor of its white part.
    """
    window = fit.windows[i].with_(colour=colours)
    channels: dict[str, Noise] = {}
    share = 0.0
    total = sum(int(window.used[c].sum()) for c in window.channels)
    bins = np.asarray(np.fft.rfftfreq(len(window), 1.0 / window.rate), dtype=np.float64)
    for channel in window.channels:
        used, before, open_ = window.used[channel], known[channel], 0.0
        if channel in colours:
            before = _white_at_rest(before, colours[channel], i)
            open_ = float(np.mean(colours[channel].log_error(bins, window.rate)))
        residual = window.in_noise(channel, np.where(used, fit.residual(channel, i), 0.0))
        std, error = high_band_floor(
            window.sigma[channel] * residual[window.lead :],
            window.rate,
            _BAND_ABOVE * fit.frequency / (2.0 * np.pi),
        )
        channels[channel] = _combine(before, std, error)
        relative = channels[channel].uncertainty / channels[channel].std
        share += (int(used.sum()) / total * float(np.hypot(2.0 * relative, open_))) ** 2
    spread = float(np.sqrt(2.0 / max(fit.degrees, 1) + share))
    return Floor(channels, spread)


def _white_at_rest(known: Noise, colour: ChannelColour, i: int) -> Noise:
    std = colour.white[i] or next((std for std in colour.white if std), None)
    if std is None:
        return known
    return Noise(std, std / np.sqrt(2.0 * SHORTEST), f"{known.source}, {colour.words}")


def _combine(known: Noise, std: float, error: float) -> Noise:
    if not np.isfinite(error) or std <= 0.0:
        return known
    if not np.isfinite(known.uncertainty) or known.std <= 0.0:
        return Noise(std, error, _BAND)
    apart = (std - known.std) / float(np.hypot(known.uncertainty, error))
    if apart > _DISAGREE:
        return known
    if apart < -_DISAGREE:
        return Noise(std, error, _BAND)
    weights = np.array([known.uncertainty**-2, error**-2])
    mean = float(weights @ np.array([known.std, std]) / weights.sum())
    source = known.source if _BAND in known.source else f"{known.source} and {_BAND}"
    return Noise(mean, float(weights.sum() ** -0.5), source)


_SETTLED = 1e-4
"""Gain of chi-square that ends a fit whose numbers are stated: where it began does not show in their digits."""

_LINES = 3
"""Lines of a channel's residual that are looked for."""

_STALE_OFF = 3.5
"""Noise standard deviations off the fit at which a stale reading counts as lost."""


@dataclass(frozen=True, eq=False)
class Baseline:
    """A model fitted to releases, and the noise floor to which its residual is compared."""

    decays: tuple[PreparedDecay, ...]
    fit: Fit
    floors: tuple[Floor, ...]

    @property
    def spread(self) -> float:
        """Standard error of the reduced chi-square of an adequate model, decided once for these records."""
        decided = [prepared.floor_std for prepared in self.decays]
        each = [
            floor.chi_square_std if std is None else std
            for std, floor in zip(decided, self.floors, strict=True)
        ]
        return float(np.sqrt(np.mean(np.square(each))))

    @property
    def floor_is_sure(self) -> bool:
        """Whether a misfit above the floor cannot be noise: the noise was seen at rest, and two channels agree on it."""
        return all(
            prepared.window.paired and all("rest" in noise.source for noise in prepared.noise.values())
            for prepared in self.decays
        )

    @property
    def alpha(self) -> float:
        """The probability of a false claim that is allowed on these records."""
        return DOUBT if self.floor_is_sure else DOUBT_AT_A_GUESS

    @property
    def largest(self) -> PreparedDecay:
        """The release of the largest amplitude."""
        return max(self.decays, key=lambda prepared: prepared.amplitude)

    @cached_property
    def scales(self) -> Scales:
        """The sizes from which one more effect takes its starting values, with the lines of the residual."""
        return scales_of(self.decays[0], residual_lines(self.fit))

    @cached_property
    def walk(self) -> RandomWalk:
        """The random walk of spring and damper beside the fitted model."""
        return walk_beside(self.fit)

    def stated(self, found: Fit, *, drifts: bool = True) -> Fit:
        """Give a fit the standard errors to state: its own where it is adequate, else those of the misfit.

        They allow for a random walk of spring and damper that brings the fit to the floor, or remains beside it there.
        Without `drifts` they do not, for where many fits are listed: a walk takes a tenth of a second each.
        """
        adequate = self.adequate(found)
        stated = found if adequate else with_misfit_errors(found)
        if not drifts:
            return stated
        walk = self.walk
        if found is not self.fit and walk.evidence > RIVALS_WITHIN:  # else there is none beside one law more
            walk = walk_beside(found)
        reached = adequate or (self.floor_is_sure and self.reached_with(walk.simulated))
        return with_walk_errors(stated, walk) if reached else stated

    def reached_with(self, walk: RandomWalk) -> bool:
        """Check that a fit reaches the floor together with the walk beside it."""
        return walk.settled and self._reaches(walk.reduced)

    def reduced(self, found: Fit) -> float:
        """Reduced chi-square that includes the faults which are corrected but not named in the model."""
        faults = unnamed_faults(self.decays, found)
        readings = found.degrees + sum(fault.readings for fault in faults)
        return (found.chi_square + sum(fault.drop for fault in faults)) / max(readings, 1)

    @property
    def at_floor(self) -> bool:
        """Whether the fitted model reaches the floor, including the faults that it does not name."""
        return self._reaches(self.reduced(self.fit)) and not self._denied(self.fit)

    def adequate(self, found: Fit) -> bool:
        """Check whether a fit reaches the floor, leaving out corrected faults.

        A floor that is a guess gives the benefit of doubt, unless the residual stands at the motion's harmonics.
        """
        return self._reaches(found.reduced) and not self._denied(found)

    def harmonics(self, found: Fit) -> HarmonicResidual | None:
        """Measure a residual near a guessed floor at the motion's harmonics; None where the floor itself decides."""
        if self.floor_is_sure or not self._reaches(found.reduced):
            return None
        return harmonic_residual(found)

    def _denied(self, found: Fit) -> bool:
        harmonics = self.harmonics(found)
        return harmonics is not None and harmonics.against

    @property
    def highest(self) -> float:
        """The largest reduced chi-square that counts as at the floor."""
        return 1.0 + max(ADEQUATE * self.spread, 0.0 if self.floor_is_sure else BENEFIT_OF_DOUBT)

    def _reaches(self, reduced: float) -> bool:
        return reduced <= self.highest


def fit_baseline(
    decays: tuple[PreparedDecay, ...], model: Model, known: dict[str, float] | None = None
) -> Baseline:
    """Fit a model and decide the floor with its residual; `known` are values to begin from, by unknown's name.

    The width of the floor is decided by the first model that is fitted to a release, and carried in its `floor_std`.
    """
    windows = tuple(prepared.window for prepared in decays)
    frequency = decays[0].frequency
    start = known if known is not None else initial_values(decays, model, {})
    # By equation error the motion may run away, or friction may stop it too early: no step leads out of that.
    starts = (
        own_springs(decays, model, one) | one for one in (start, start | _linear_oscillator(model, frequency))
    )
    found = min((fit(model, windows, one, frequency) for one in starts), key=lambda one: one.chi_square)
    mended = tuple(_without_stale(prepared, found, i) for i, prepared in enumerate(decays))
    if mended != decays:
        found = fit(model, tuple(prepared.window for prepared in mended), found.point, frequency)
    return refit_at_floor(mended, found)


def _linear_oscillator(model: Model, frequency: float) -> dict[str, float]:
    """Return the strengths of a model that is a spring with 1 % of the critical damping, at a frequency (rad/s)."""
    parts = {LinearPart.STIFFNESS: frequency**2, LinearPart.DAMPING: 0.02 * frequency}
    strengths = ((term.strength, term.force.linear_part) for term in model.forces)
    return {str(strength): 0.0 if part is None else parts.get(part, 0.0) for strength, part in strengths}


def with_floor(prepared: PreparedDecay, width: float) -> PreparedDecay:
    """Decide the standard error of the reduced chi-square at a release's floor, unless that was decided before."""
    return prepared if prepared.floor_std is not None else replace(prepared, floor_std=width)


def _without_stale(prepared: PreparedDecay, found: Fit, i: int) -> PreparedDecay:
    """Leave out the stale readings that only a fit can show, in channels that are known to lose readings."""
    lost, used = dict(prepared.lost), dict(prepared.window.used)
    for channel, mask in prepared.lost.items():
        if int(mask.sum()) < FEWEST_LOST:
            continue
        off = np.abs(found.residual(channel, i)) > _STALE_OFF * prepared.window.sigma[channel]
        further = stale(prepared.window.readings[channel]) & off & used[channel]
        if further.any():
            lost[channel] = mask | further
            used[channel] = used[channel] & ~further
    if all(lost[channel] is prepared.lost[channel] for channel in lost):
        return prepared
    return replace(prepared, lost=lost, window=prepared.window.with_(used=used))


def refit_at_floor(decays: tuple[PreparedDecay, ...], found: Fit) -> Baseline:
    """Fit again with the noise floor that the fit's own residual shows, and store its width in releases that have none.

    A record has one width, whatever is fitted later.
    """
    colours = noise_colours(decays, found)
    floors = tuple(refined_floor(found, i, prepared.noise, colours) for i, prepared in enumerate(decays))
    windows = tuple(
        window.with_(sigma={c: floor.channels[c].std for c in window.channels}, colour=colours)
        for floor, window in zip(floors, found.windows, strict=True)
    )
    settled = fit(found.model, windows, found.point, found.frequency, near=True, tolerance=_SETTLED)
    baseline = Baseline(decays, settled, floors)
    return replace(baseline, decays=tuple(with_floor(prepared, baseline.spread) for prepared in decays))


def force_along_motion(prepared: PreparedDecay, found: Fit, i: int) -> Array:
    """Return the force per unit mass of a fitted model along the motion of window i, strengths by equation error, (n,)."""
    parameters = {name: estimate.value for name, estimate in found.parameters.items()}
    inner = values_in_release(parameters, release_numbers(found.windows)[0][i])
    return prepared.restoring - regress_model(prepared, found.model, inner).residual


def residual_lines(found: Fit) -> dict[str, tuple[tuple[float, float, float], ...]]:
    """Find the strongest lines of each channel's residual, over all windows: (Hz, amplitude, phase at the release)."""
    lines: dict[str, tuple[tuple[float, float, float], ...]] = {}
    for i, window in enumerate(found.windows):
        for channel in window.channels:
            residual = np.where(window.used[channel], found.residual(channel, i), 0.0)[window.lead :]
            time = window.time + window.lead / window.rate
            lines[channel] = lines.get(channel, ()) + strongest_lines(residual, window.rate, time, _LINES)
    return lines
