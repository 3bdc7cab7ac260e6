"""The setting of a fit: the span that is compared, and the motion that it shows."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from identify.arrays import Array, Mask
from identify.formatting import scaled
from identify.free_decay import FreeDecay
from identify.preprocessing.aligned_decay import AlignedDecay, locate_and_align
from identify.preprocessing.alignment import Alignment
from identify.preprocessing.averaged_decay import FEW, averaged
from identify.preprocessing.equation_error import moving, regress
from identify.preprocessing.fit_window import FitWindow
from identify.preprocessing.motion import SHORTEST, Motion, reconstruct
from identify.preprocessing.noise import SHORTEST_REST, Noise
from identify.preprocessing.noise_colour import RestColour, colour_at_rest
from identify.preprocessing.pre_release import pre_release_motion
from identify.preprocessing.record_use import RecordUse, record_use
from identify.preprocessing.release import Release
from identify.preprocessing.usable import above, base_columns, floor_of, refusal
from identify.summary import Summarised, Summary

_SHORTEST_CYCLES = 4.0
BESIDE_OTHERS = 2.0
"""Cycles that a release must hold which is fitted together with others: it brings its start, they the rest."""

_LAG_REACH = 0.06
_REVERSAL_MARGIN = 0.02
"""Share of the interval between two samples by which the time of a reversal is uncertain."""

_REVERSAL_IN_BLOCK = 0.5
"""The same where a reading is the mean of a block: a reversal anywhere in it has put both sides of the jump into it."""


@dataclass(frozen=True, eq=False)
class Rest:
    """Readings of each channel at rest before the release, shape (m,), SI; `time` counts from the release."""

    time: Array
    readings: dict[str, Array]


@dataclass(frozen=True, eq=False, repr=False)
class PreparedDecay(Summarised):
    """One release made ready to be fitted.

    `window` holds the readings, `motion` the displacement (from the spring's zero), velocity and acceleration along
    it, on the acceleration's clock; `frequency` is the angular frequency (rad/s); `alignment` is None with one
    channel. `zero` is the displacement reading at the spring's zero, `noise` what was known of the noise before any
    fit, and `lost` marks the readings of each channel that its sensor repeated or lost. `rest` is None where none was
    recorded. `block` is how many readings of the record each one here is the mean of, and `share` the share of its
    motion that is fitted where this is one of several pieces of a long release. `mass` is in kg (kg m^2 for angles), None
    where it is unknown. `use` says which part of the record this is, and why it ends there. `floor_std` is the standard
    error of the reduced chi-square of a model that explains the record; None until a first fit has decided it.
    """

    window: FitWindow
    motion: Motion
    frequency: float
    alignment: Alignment | None
    zero: float
    noise: dict[str, Noise]
    lost: dict[str, Mask]
    rest: Rest | None = None
    block: int = 1
    share: float = 1.0
    mass: float | None = None
    use: RecordUse | None = None
    floor_std: float | None = None

    def brief(self) -> Summary:
        """Summarize the record that will be fitted."""
        window = self.window
        cycles = len(window) / window.rate * self.frequency / (2.0 * np.pi)
        sentence = (
            f"{cycles:.1f} cycles at {self.frequency / (2.0 * np.pi):.4g} Hz from {scaled(self.amplitude, window.unit)}, "
            f"{', '.join(window.channels)}."
            + (f" Each reading is the mean of {self.block}." if self.block > 1 else "")
        )
        rows = [(name, scaled(noise.std, ""), noise.source) for name, noise in self.noise.items()]
        return Summary("Prepared decay", (sentence,), ("channel", "noise (SI)", "read from"), rows)

    @property
    def time(self) -> Array:
        """Time since the release of each sample of the motion, s."""
        return self.window.time + np.arange(len(self.motion.displacement)) / self.window.rate

    @property
    def restoring(self) -> Array:
        """Measured restoring force per unit mass along the motion: the external force, if any, less inertia's, (n,)."""
        external = 0.0 if self.window.force is None else self.window.force
        return np.asarray(external - self.motion.acceleration)

    @cached_property
    def rest_colour(self) -> dict[str, RestColour]:
        """The colour of each channel's noise, estimated from the rest."""
        if self.rest is None:
            return {}
        rate = (len(self.rest.time) - 1) / float(self.rest.time[-1] - self.rest.time[0])
        found = {c: colour_at_rest(readings, rate) for c, readings in self.rest.readings.items()}
        return {channel: colour for channel, colour in found.items() if colour is not None}

    @property
    def amplitude(self) -> float:
        """Largest displacement from zero, in the unit of the displacement."""
        return float(np.max(np.abs(self.motion.displacement)))


def prepare(
    decay: FreeDecay | AlignedDecay, *, gain_uncertainty: float = 0.0, fewest_cycles: float = _SHORTEST_CYCLES
) -> PreparedDecay:
    """Make one release ready to be fitted: locate, align, reconstruct the motion, cut the record where friction takes over.

    `gain_uncertainty` is the relative uncertainty of the gain between the
    two channels that their calibrations leave open, 0 where they say nothing. Where a recorded force drives the motion
    on, it is taken into account, and the mass is estimated unless it is known. Raises NotIdentifiable when fewer than
    `fewest_cycles` remain: four, of a release that stands alone; `BESIDE_OTHERS`, of one among several.
    """
    located = decay if isinstance(decay, AlignedDecay) else locate_and_align(decay)
    aligned, block = averaged(located)
    record, corrected, noise = aligned.recorded, aligned.decay, aligned.noise
    release = _most_active(record, aligned.release) if record.driven else aligned.release
    motion = reconstruct(corrected.with_(release=release.settle))
    motion = motion.part(slice(max(release.end - release.settle, 0)))
    if len(motion.displacement) < SHORTEST:
        raise refusal(record, "The motion after the release is too short; record at least four cycles.")
    force = _force(record, release, motion)
    restoring = -motion.acceleration if force is None else force - motion.acceleration
    base = regress(restoring, base_columns(motion), moving(motion))
    k, _, mu_0 = base.strengths
    if not 0.0 < k < (np.pi * record.rate) ** 2:
        raise refusal(record, _no_spring(record))
    frequency = float(np.sqrt(k))
    zero = -base.constant / k
    sigma = {name: max(found.std, 1e-300) for name, found in noise.items()}
    length = above(motion, frequency, max(mu_0, 0.0) / k, floor_of(sigma, frequency))
    cycles = length * frequency / (2.0 * np.pi * record.rate)
    begin = (release.settle - release.time_s * record.rate) / record.rate
    to_the_end = length == len(motion.displacement)
    use = record_use(
        located, begin, begin + length / record.rate, 2.0 * np.pi / frequency, to_the_end=to_the_end
    )
    if cycles < fewest_cycles:
        raise refusal(record, _too_few(cycles, frequency, use, fewest_cycles))
    motion = replace(motion.part(slice(length)), displacement=motion.displacement[:length] - zero)
    lost = {name: mask[release.settle :][: len(motion.displacement)] for name, mask in aligned.lost.items()}
    window = _window(
        record, release, motion, frequency, sigma, aligned.alignment, lost, gain_uncertainty
    ).with_(force=None if force is None else force[:length], force_known=record.mass is not None)
    window = _without_reversals(window, motion, max(mu_0, 0.0), averaged=block > 1)
    return PreparedDecay(
        window.with_(pre_release=pre_release_motion(aligned, release, zero)),
        motion,
        frequency,
        aligned.alignment,
        zero,
        noise,
        lost,
        _rest_of(record, release),
        block,
        mass=record.mass,
        use=use,
    )


def _no_spring(record: FreeDecay) -> str:
    """Say why no stiffness is seen: with two channels one may be reversed or clip; a single channel may hold only noise."""
    if len(record.channels) > 1:
        return (
            "The motion shows no restoring force that these readings could show: is the displacement's sign reversed, or "
            "does a channel clip?"
        )
    return (
        "The motion shows no restoring force above the noise of its only channel: is this the column that swings? If it is, "
        "release from a larger amplitude, or use a sensor with less noise."
    )


def _too_few(cycles: float, frequency: float, use: RecordUse, fewest: float) -> str:
    at_least = "four" if fewest == _SHORTEST_CYCLES else f"{fewest:g} beside other releases"
    if use.ended == "readings_missing":
        before = min((use.end_s - use.begin_s) * frequency / (2.0 * np.pi), fewest - 0.1)
        return (
            f"Only {before:.1f} cycles of free motion lie before {use.end_s:.2f} s, where {use.missing_s:.2g} s of readings "
            f"are missing; at least {at_least} are needed: cut the record so that it begins after them, or record again."
        )
    return (
        f"Only {min(cycles, fewest - 0.1):.1f} cycles of free motion stand above friction "
        f"and noise; record at least {at_least}, from a larger release."
    )


def _most_active(decay: FreeDecay, release: Release) -> Release:
    """Return the stretch of the largest motion in a driven record, which has no decay to be followed from its start."""
    reading = next(iter(decay.channels.values()))
    if len(reading) <= FEW:
        return release
    power = np.cumsum(np.square(reading - np.mean(reading)))
    first = int(np.argmax(power[FEW:] - power[:-FEW]))
    return replace(release, settle=first, end=first + FEW)


def _force(decay: FreeDecay, release: Release, motion: Motion) -> Array | None:
    """Return the external force per unit mass along the motion (n,), the mass by equation error unless it is known."""
    if decay.force is None or not decay.driven:
        return None
    force = decay.force[release.settle :][: len(motion.displacement)]
    if decay.mass is not None:
        return force
    columns = np.column_stack([base_columns(motion), -force])
    return np.asarray(regress(-motion.acceleration, columns, moving(motion)).strengths[-1] * force)


def _rest_of(decay: FreeDecay, release: Release) -> Rest | None:
    first, last = release.rest
    if last - first < SHORTEST_REST:
        return None
    readings = {channel: values[first:last] for channel, values in decay.channels.items()}
    return Rest(decay.time[first:last] - release.time_s, readings)


def _without_reversals(
    window: FitWindow, motion: Motion, friction: float, *, averaged: bool = False
) -> FitWindow:
    """Leave out acceleration readings of which it is left to chance on which side of dry friction's jump they lie.

    `friction` is Coulomb's, per unit mass: the velocity between samples is wrong by up to a quarter of its jump times
    the interval where the jump falls. In a loud channel a jump is not seen, and nothing is left out.
    """
    if "acceleration" not in window.used or motion.noise_displacement is not None:
        return window
    share = _REVERSAL_MARGIN + (_REVERSAL_IN_BLOCK if averaged else 0.0)
    timing = np.abs(motion.acceleration) * share / motion.rate
    margin = timing + 4.0 * motion.noise_velocity + 0.5 * friction / motion.rate
    clear = np.abs(motion.velocity) >= margin
    return window.with_(used=window.used | {"acceleration": window.used["acceleration"] & clear})


def _window(
    decay: FreeDecay,
    release: Release,
    motion: Motion,
    frequency: float,
    noise: dict[str, float],
    alignment: Alignment | None,
    lost: dict[str, Mask],
    gain_uncertainty: float,
) -> FitWindow:
    start, length = release.settle, len(motion.displacement)
    lag, gain = (alignment.lag.value, alignment.gain.value) if alignment is not None else (0.0, 1.0)
    reach = _LAG_REACH * 2.0 * np.pi / frequency
    lead = int(np.ceil((abs(lag) + 0.2 * reach) * decay.rate)) + 1 if alignment is not None else 1
    part = slice(start, start + length)
    readings = {channel: values[part] for channel, values in decay.channels.items()}
    compared = decay.known[part] & (np.arange(length) >= lead)
    return FitWindow(
        rate=decay.rate,
        time=(start - release.time_s * decay.rate) / decay.rate,
        readings=readings,
        used={c: compared & ~lost[c] if c in lost else compared for c in readings},
        sigma=noise,
        lead=lead,
        lag=lag,
        lag_reach=reach,
        gain=gain,
        gain_uncertainty=gain_uncertainty,
        unit=decay.unit,
        rate_std=decay.rate_std,
    )
