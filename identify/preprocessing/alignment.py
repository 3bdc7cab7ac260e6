"""Alignment: the lag and the gain between two channels, by kinematics alone."""

from dataclasses import dataclass, replace

import numpy as np

from identify.errors import NotIdentifiable
from identify.estimate import Estimate
from identify.free_decay import FreeDecay
from identify.preprocessing.noise import noise_levels
from identify.preprocessing.release import HAND_S
from identify.preprocessing.sampling import average_blocks
from identify.signal.fractional_delay import bridge, read_at_shift
from identify.signal.kinematics import Agreement, Pair, agree, reversal_excess
from identify.signal.oscillation import dominant_frequency, running_amplitude
from identify.signal.smoothing import slope

ONE_CHANNEL = (
    "There is no lag to find without an acceleration beside a displacement or velocity: record both."
)

LEAST_EXCESS = 0.7
"""The misfit corrects a floor read too high from a short rest, but not beyond what such a floor can be off."""

TOO_LITTLE = "The motion is too small against the noise to find the lag of the channels: release from a larger amplitude."

ENOUGH_PER_PERIOD = 64
"""Faster recordings are averaged down to about this many samples a period: both channels alike, so the lag stays."""

_HARMONICS = 3.0
"""Corner, in units of the motion's frequency, of the motion that lag and gain are read by: above it is noise."""

CONTRADICTION = 4.0
"""The lag found and the lag stated are two estimates of one lag up to this many standard errors of their difference."""


@dataclass(frozen=True)
class Alignment:
    """Lag and gain of the displacement (or velocity) channel relative to the acceleration channel.

    `lag` in s is positive when the displacement is late. `gain` is the acceleration's gain relative to
    the second derivative of the displacement (1 when the calibrations agree), dimensionless.
    `method` names how it was found; `caution` is a sentence when the answer is weaker than usual, or "".
    """

    lag: Estimate
    gain: Estimate
    method: str
    caution: str = ""


def align(decay: FreeDecay) -> Alignment:
    """Return lag and gain between the displacement (or velocity) and the acceleration, from kinematics alone.

    Maximum likelihood of N a = g H u (see `identify.signal.kinematics`), which holds under any force and from any state at
    either end. Raises NotIdentifiable with fewer than two channels or too little motion.
    """
    if decay.acceleration is None or (decay.displacement is None and decay.velocity is None):
        raise NotIdentifiable(ONE_CHANNEL)
    frequency = dominant_frequency(bridge(decay.acceleration, decay.known)[decay.start :], decay.rate)
    if frequency <= 0:
        raise NotIdentifiable(
            "The channels hold no oscillation to align: record a release with a visible decay."
        )
    decay, _ = average_blocks(decay, int(decay.rate / (ENOUGH_PER_PERIOD * frequency)), frequency)
    pair = pair_of(decay)
    moving = slice(decay.start, None)
    _require_motion(pair, moving, frequency)
    try:
        return _aligned(pair, moving, frequency, decay.stated_lag)
    except np.linalg.LinAlgError as error:
        raise NotIdentifiable(TOO_LITTLE) from error


def _aligned(pair: Pair, moving: slice, frequency: float, stated: Estimate | None) -> Alignment:
    upright, opposite = _starts(pair, moving, frequency)
    corner = _HARMONICS * frequency / pair.rate
    best = agree(pair, *upright, corner)
    if best.chi_square > 2.0 * best.degrees:
        other = agree(pair, *opposite, corner)
        best = other if 2.0 * other.chi_square < best.chi_square else best
    pair = with_reversals(pair, best)
    found = agree(pair, best.lag, best.gain, corner)
    return _judged(pair, found, frequency, stated)


def _require_motion(pair: Pair, moving: slice, frequency: float) -> None:
    """Raise NotIdentifiable unless the oscillation stands above the noise in both channels."""
    period = max(2, round(pair.rate / frequency))
    for values, variance in ((pair.low, pair.variance_low), (pair.high, pair.variance_high)):
        amplitude = float(running_amplitude(values[moving], period).max())
        if amplitude < 8.0 * float(np.sqrt(np.min(variance))) / np.sqrt(period):
            raise NotIdentifiable(TOO_LITTLE)


def with_reversals(pair: Pair, found: Agreement) -> Pair:
    """Return the pair with what jumps of the acceleration add to its averages, as far as they are reversals."""
    low, _ = read_at_shift(found.low, found.lag * pair.rate)
    velocity = slope(low, pair.rate) if pair.order == 2 else low
    noise = float(np.sqrt(np.min(pair.variance_high)))
    return replace(pair, excess=reversal_excess(pair.high, velocity, noise, pair.order))


def correct(decay: FreeDecay, alignment: Alignment) -> FreeDecay:
    """Return the decay with the displacement (or velocity) moved earlier by the lag, a true fractional delay.

    The acceleration is divided by its gain, so that it is the second derivative of the displacement.
    Samples that the move takes from beyond the record, or from a lost sample, are marked as not valid.
    """
    (name, values), *_ = decay.channels.items()
    moved, known = read_at_shift(values, alignment.lag.value * decay.rate, decay.valid)
    valid = known if decay.valid is None else known & decay.valid
    acceleration = decay.channels["acceleration"] / alignment.gain.value
    return decay.with_(
        **{name: moved, "acceleration": acceleration, "valid": None if bool(valid.all()) else valid}
    )


def pair_of(decay: FreeDecay, *, leave_out_hand: bool = True) -> Pair:
    """Return the displacement (or velocity) and the acceleration with the variance of every sample."""
    (low_name, low), *_ = decay.channels.items()
    order, high = 2 if low_name == "displacement" else 1, decay.channels["acceleration"]
    valid, levels = decay.known, noise_levels(decay)
    noise_low, noise_high = levels[low_name], levels["acceleration"]
    variance_low, variance_high = np.full(len(decay), noise_low**2), np.full(len(decay), noise_high**2)
    out = ~valid
    if leave_out_hand and decay.start > 0:
        after = decay.start + max(4, int(np.ceil(HAND_S * decay.rate)))
        out[max(decay.start - 4, 0) : after] = True
    variance_low[out] = max(float(np.ptp(low[valid])), noise_low) ** 2
    variance_high[out] = max(float(np.ptp(high[valid])), noise_high) ** 2
    return Pair(
        bridge(low, valid),
        bridge(high, valid),
        order,
        decay.rate,
        variance_low,
        variance_high,
        np.zeros(len(decay)),
    )


def _starts(pair: Pair, moving: slice, frequency: float) -> list[tuple[float, float]]:
    """Coarse lag and gain from the cross-spectrum around the oscillation, for either sign of the gain."""
    low, high = pair.low[moving], pair.high[moving]
    taper = np.hanning(len(low))
    size = 4 * len(low)
    bins = np.fft.rfftfreq(size, 1.0 / pair.rate)
    derivative = (2j * np.pi * bins) ** pair.order * np.fft.rfft((low - low.mean()) * taper, size)
    measured = np.fft.rfft((high - high.mean()) * taper, size)
    band = (bins > 0.7 * frequency) & (bins < 1.3 * frequency)
    cross = np.sum(measured[band] * np.conj(derivative[band]))
    size_of_gain = abs(cross) / max(float(np.sum(np.abs(derivative[band]) ** 2)), 1e-300)
    angle = float(np.angle(cross))
    opposite = angle - np.pi if angle > 0 else angle + np.pi
    omega = 2.0 * np.pi * frequency
    return [(angle / omega, size_of_gain), (opposite / omega, -size_of_gain)]


def _judged(pair: Pair, found: Agreement, frequency: float, stated: Estimate | None) -> Alignment:
    name = "displacement" if pair.order == 2 else "velocity"
    excess = max(found.chi_square / max(found.degrees, 1), LEAST_EXCESS)
    gain_std, lag_std = np.sqrt(excess * np.diag(found.covariance)[:2])
    method = f"maximum likelihood of acceleration against {name}, kinematics only"
    cautions = []
    if not np.isfinite(lag_std) or lag_std > 0.1 / frequency or gain_std > 0.3 * abs(found.gain):
        raise NotIdentifiable(TOO_LITTLE)
    if stated is not None and abs(found.lag - stated.value) > CONTRADICTION * np.hypot(lag_std, stated.std):
        cautions.append(
            f"By the data sheets the lag is {1e3 * stated.value:.3g} ms: suspect the delays that the board states."
        )
    if excess > 1.5:
        cautions.append(
            f"The channels disagree by {np.sqrt(excess):.1f} times their noise even when aligned: suspect a sensor."
        )
    if found.gain < 0:
        cautions.append("The two channels have opposite signs.")
    if lag_std * frequency > 0.002:
        cautions.append("The lag is known to no better than 0.2 % of a period: record a larger release.")
    lag, gain = Estimate(found.lag, float(lag_std), "s"), Estimate(found.gain, float(gain_std), "1")
    return Alignment(lag, gain, method, " ".join(cautions))
