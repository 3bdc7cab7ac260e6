"""Motion: displacement, velocity and acceleration that agree with each other."""

from dataclasses import dataclass, replace

import numpy as np

from identify.arrays import Array, Mask, frozen, frozen_mask
from identify.errors import NotIdentifiable
from identify.free_decay import FreeDecay
from identify.preprocessing.alignment import pair_of, with_reversals
from identify.preprocessing.noise import noise_levels
from identify.signal.fractional_delay import bridge
from identify.signal.integration import integrate, slow_part
from identify.signal.kinematics import agree, cut, reversal_excess
from identify.signal.oscillation import dominant_frequency
from identify.signal.smoothing import gain_of, slope, smooth, smooth_to_noise

SHORTEST = 16

ABOVE_NOISE = 8.0
"""Noise standard deviations down to which a motion is fitted: of a reading, or, of a loud channel, of what is made of it."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Consistent displacement (m), velocity (m/s), acceleration (m/s^2), each of shape (n,).

    `start` is the index of the first sample in the record they were made from, `rate` is in Hz; `valid` is
    False where a sample was lost or an edge makes the values unreliable. `source` says which channels
    they were made from ("displacement and acceleration", "acceleration", "displacement", "velocity").
    `noise_velocity` and `noise_acceleration` are the standard errors of a sample; `noise_displacement` that of
    a loud channel's displacement, once it is smoothed.
    """

    rate: float
    start: int
    displacement: Array
    velocity: Array
    acceleration: Array
    valid: Mask
    source: str
    noise_velocity: float
    noise_acceleration: float
    noise_displacement: float | None = None

    def part(self, samples: slice) -> "Motion":
        """Return some of the samples, one after another."""
        return replace(
            self,
            displacement=self.displacement[samples],
            velocity=self.velocity[samples],
            acceleration=self.acceleration[samples],
            valid=self.valid[samples],
        )


def reconstruct(decay: FreeDecay) -> Motion:
    """Return displacement, velocity and acceleration that agree, from the release to the end of the record.

    From both channels: the most likely motion under a = D^2 u, displacement for the low band and acceleration for the
    high one, each with the weight of its noise; the acceleration's offset and slow drift are removed.
    From one channel: integration with the low frequencies removed, or differentiation with the noise in view.
    The channels are taken as aligned (see `identify.preprocessing.alignment.correct`). Raises NotIdentifiable when fewer
    than 16 readings follow the release.
    """
    start = decay.start
    known = decay.known[start:]
    if known.sum() < SHORTEST:
        raise NotIdentifiable(
            f"Only {known.sum()} readings follow the release; at least {SHORTEST} are needed."
        )
    (name, lowest), *others = decay.channels.items()
    if others and decay.acceleration is not None:
        return _from_pair(decay, known, f"{name} and acceleration")
    values, noise = bridge(lowest[start:], known), noise_levels(decay)[name]
    frequency = dominant_frequency(values, decay.rate)
    if frequency <= 0.0:
        raise NotIdentifiable("The channel holds no oscillation: record a release with a visible decay.")
    if name == "displacement":
        return _from_displacement(decay, known, values, noise, frequency)
    if name == "velocity":
        return _from_velocity(decay, known, values, noise, frequency)
    return _from_acceleration(decay, known, values, noise, frequency)


def _motion(
    decay: FreeDecay,
    known: Mask,
    source: str,
    edge: int,
    parts: tuple[Array, Array, Array],
    noise: tuple[float, float],
    noise_displacement: float | None = None,
) -> Motion:
    """Return displacement, velocity and acceleration, unreliable for `edge` samples at either end, as a motion.

    `noise` is that of velocity and acceleration.
    """
    reliable = known.copy()
    reliable[:edge] = False
    reliable[len(reliable) - edge :] = False
    u, v, a = map(frozen, parts)
    return Motion(decay.rate, decay.start, u, v, a, frozen_mask(reliable), source, *noise, noise_displacement)


def _from_pair(decay: FreeDecay, known: Mask, source: str) -> Motion:
    pair = cut(pair_of(decay, leave_out_hand=False), decay.start)
    pair = with_reversals(pair, agree(pair, 0.0, 1.0))
    found = agree(pair, 0.0, 1.0)
    rate, low, high = pair.rate, found.low, found.high
    noise = _posterior_noise(
        pair.order, rate, *(float(np.sqrt(np.min(v))) for v in (pair.variance_low, pair.variance_high))
    )
    if pair.order == 2:
        return _motion(decay, known, source, 4, (low, _slope_of_pair(low, high, rate), high), noise)
    raw = integrate(low, rate)
    slow = slow_part(raw, rate, dominant_frequency(high, rate), np.ones(len(raw), dtype=bool))
    return _motion(decay, known, source, 4, (raw - slow.value, low, high), noise)


def _slope_of_pair(low: Array, high: Array, rate: float) -> Array:
    """Velocity from displacement and acceleration, exact to degree 7: Hermite's formula with one more pair of points."""
    velocity = slope(low, rate)
    velocity[2:-2] = (low[3:-1] - low[1:-3]) * rate / 2.0 - (
        74.0 * (high[3:-1] - high[1:-3]) - 7.0 * (high[4:] - high[:-4])
    ) / (720.0 * rate)
    return velocity


def _posterior_noise(order: int, rate: float, noise_low: float, noise_high: float) -> tuple[float, float]:
    """Standard errors of velocity and acceleration of the blend, from the two floors."""
    omega = (np.arange(2048) + 0.5) / 2048 * np.pi * rate
    low = 1.0 / (noise_low**-2 + omega ** (2 * order) * noise_high**-2)
    to_velocity = omega**2 if order == 2 else 1.0
    return float(np.sqrt(np.mean(to_velocity * low))), float(np.sqrt(np.mean(omega ** (2 * order) * low)))


def _from_displacement(
    decay: FreeDecay, known: Mask, values: Array, noise: float, frequency: float
) -> Motion:
    rate = decay.rate
    loud = _is_loud(values[known], noise, frequency, rate)
    smoothed, corner = smooth_to_noise(values, noise, frequency / rate, known, loud=loud)
    velocity = slope(smoothed, rate)
    left, *noises = (_passed(noise, corner, rate, n) for n in range(3))
    parts = smoothed, velocity, slope(velocity, rate)
    return _motion(
        decay, known, "displacement", _edge(corner), parts, (noises[0], noises[1]), left if loud else None
    )


def _is_loud(values: Array, noise: float, frequency: float, rate: float) -> bool:
    """Check whether the noise that the usual smoothing leaves in the velocity would hide its sign for half of the motion."""
    speed = 2.0 * np.pi * frequency * float(np.std(values))
    return 3.0 * _passed(noise, 5.0 * frequency / rate, rate, 1) > 0.5 * speed


def _from_velocity(decay: FreeDecay, known: Mask, values: Array, noise: float, frequency: float) -> Motion:
    rate = decay.rate
    smoothed, corner = smooth_to_noise(values, noise, frequency / rate, known)
    raw = integrate(smoothed, rate)
    slow = slow_part(raw, rate, frequency, known)
    parts = raw - slow.value, smoothed - slow.first, slope(smoothed, rate) - slow.second
    noises = _passed(noise, corner, rate, 0), _passed(noise, corner, rate, 1)
    return _motion(decay, known, "velocity", _edge(corner), parts, noises)


def _edge(corner: float) -> int:
    """Count the samples at either end that smoothing with a corner (cycles a sample) makes unreliable."""
    return int(np.ceil(1.0 / corner)) + 2


def _from_acceleration(
    decay: FreeDecay, known: Mask, values: Array, noise: float, frequency: float
) -> Motion:
    rate = decay.rate
    centred = values - values.mean()
    excess = np.zeros(len(values))
    for _ in range(2):
        velocity = integrate(centred, rate, excess)
        raw = integrate(velocity, rate)
        slow = slow_part(raw, rate, frequency, known)
        excess = reversal_excess(centred, velocity - slow.first, noise, 1)
    omega = 2.0 * np.pi * frequency
    noise_velocity = float(noise / np.sqrt(rate * omega))
    largest = float(np.max(np.abs(smooth(centred, min(5.0 * frequency / rate, 0.5), known))))
    parts = raw - slow.value, velocity - slow.first, centred - slow.second
    noise_displacement = noise_velocity / omega if ABOVE_NOISE * noise > 0.5 * largest else None
    return _motion(decay, known, "acceleration", 2, parts, (noise_velocity, noise), noise_displacement)


def _passed(noise: float, corner: float, rate: float, derivatives: int) -> float:
    """Noise left after smoothing with `corner` and differentiating so many times."""
    fraction = (np.arange(1024) + 0.5) / 2048
    return float(
        noise
        * np.sqrt(np.mean((gain_of(corner, fraction) * (2.0 * np.pi * fraction * rate) ** derivatives) ** 2))
    )
