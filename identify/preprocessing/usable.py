"""The usable stretch of a motion: after the hand has let go, before the mass comes near to sticking or to its noise."""

from dataclasses import replace

import numpy as np

from identify.arrays import Array
from identify.errors import NotIdentifiable
from identify.free_decay import CHANNELS, FreeDecay
from identify.preprocessing.equation_error import moving, regress
from identify.preprocessing.motion import ABOVE_NOISE, Motion
from identify.preprocessing.release import HAND_S
from identify.preprocessing.sampling import flat_frequency, too_coarse
from identify.signal.fractional_delay import bridge
from identify.signal.running import runs_of

_APART, _LASTS = 3.0, 2.0
"""Cycles after which a motion is another one, and that it must last to be one."""


def usable(
    decay: FreeDecay, motion: Motion, noise: dict[str, float], fewest: float
) -> tuple[int, int, float]:
    """Return the first usable sample of a motion, one past the last, and its angular frequency (rad/s).

    `noise` is that of the channels which a method looks at; of a driven motion all is usable. Raises NotIdentifiable when
    it holds no oscillation or fewer than `fewest` cycles.
    """
    frequency = flat_frequency(motion.displacement, motion.rate)
    if frequency <= 0.0:
        raise NotIdentifiable("no oscillation is found in the motion; release from a larger amplitude")
    first, length, omega = 0, len(motion.displacement), 2.0 * np.pi * frequency
    if decay.force is None:
        first = max(_first_free_sample(decay, frequency) - motion.start, 0)
        free = motion.part(slice(first, None))
        k, _, mu_0 = map(float, regress(-free.acceleration, base_columns(free), moving(free)).strengths)
        sure = replace(free, velocity=np.where(free.valid, free.velocity, 0.0))
        length = above(sure, omega, max(mu_0, 0.0) / omega**2, floor_of(noise, omega))
        if length * omega < fewest * 2.0 * np.pi * motion.rate and k > omega**2:
            omega = float(np.sqrt(k))  # the spectrum is that of readings of the held mass
            length = above(sure, omega, max(mu_0, 0.0) / omega**2, floor_of(noise, omega))
    cycles = length * omega / (2.0 * np.pi * motion.rate)
    if cycles < fewest:
        raise refusal(
            decay,
            f"fewer than {fewest:g} cycles of free motion stand above friction and noise; "
            "release from a larger amplitude or record longer",
        )
    return first, first + length, omega


def _first_free_sample(decay: FreeDecay, frequency: float) -> int:
    """Return the first sample at which the hand has surely let go, at a frequency in Hz.

    Where 30 ms is more than a quarter of a cycle, the wait is that. A record without a rest before the release began in
    mid-decay: no hand, no wait.
    """
    if decay.rest[1] <= decay.rest[0]:
        return decay.start
    return decay.start + int(np.ceil(min(HAND_S, 0.25 / frequency) * decay.rate))


def base_columns(motion: Motion) -> Array:
    """Return displacement, velocity and its sign along a motion, (n, 3): the forces of the usual model."""
    return np.column_stack([motion.displacement, motion.velocity, np.sign(motion.velocity)])


def above(motion: Motion, frequency: float, stuck: float, floor: float) -> int:
    """Count the samples until the amplitude falls to a few times the band in which the mass can stick, or the noise.

    The amplitude is read from the velocity, which a drifting zero does not touch: its peaks are w (A - mu_0/k). `frequency`
    is angular (rad/s), `stuck` mu_0/k and `floor` the noise of a reading as a displacement (m), of which a loud channel's
    motion holds less. What stands out again three cycles later for less than two cycles is a knock, or the end of an
    integrated acceleration, and no motion.
    """
    floor = min(floor, motion.noise_displacement or np.inf)
    large = np.abs(motion.velocity) / frequency > 2.0 * stuck + ABOVE_NOISE * floor
    cycle = 2.0 * np.pi * motion.rate / frequency
    begin = end = count = 0
    for first, stop in runs_of(large):
        begin, end = begin if first - end < _APART * cycle else first, stop
        count = end if not count or begin < count or end - begin > _LASTS * cycle else count
    return count


def floor_of(noise: dict[str, float], frequency: float) -> float:
    """Return the noise by channel as that of a displacement (m) at an angular frequency: that of the best channel."""
    return min(noise[c] / frequency**order for order, c in enumerate(CHANNELS) if c in noise)


def refusal(record: FreeDecay, reason: str) -> NotIdentifiable:
    """Return the refusal of a record: what is wrong with its sampling, if that is, else the `reason`."""
    channel, reading = next(iter(record.channels.items()))
    coarse = too_coarse(bridge(reading, record.known), record.rate, CHANNELS.index(channel))
    return NotIdentifiable(coarse or reason)
