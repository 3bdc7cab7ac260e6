"""A line in the residual of the tracked model: a frequency that is not the motion's own."""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array
from identify.comparison.multiple_shooting import MultipleShooting
from identify.estimate import Estimate
from identify.free_decay import CHANNELS
from identify.preprocessing.fit_window import FitWindow

_APART = 0.3
_HIGH = 6.5
_APART_HIGH = 0.12
_SEEN = 12.0
_EXPECTED = 40.0


@dataclass(frozen=True)
class ResidualTone:
    """The strongest line: `frequency`, `amplitude` in the unit of `channel`, `significance` in standard errors.

    The error of its frequency is the width of a line in the record's spectrum: states that are free in every cycle move it.
    `channels` are those of several in which it is seen. `sensor` is True when the other channel lacks it where a
    motion would have shown there, with the ratio w^2 of acceleration to displacement: then it is no motion.
    """

    frequency: Estimate
    amplitude: float
    channel: str
    channels: tuple[str, ...]
    significance: float
    sensor: bool


def find_residual_tone(shooting: MultipleShooting) -> ResidualTone | None:
    """Return the strongest line away from multiples of the motion's frequency, as far as chance is not its cause.

    The spectrum is measured against its own median where that is above the noise, so that a broad misfit is no
    line. Chance reaches the limit in 1 % of records.
    """
    window = shooting.window
    n = len(window)
    left = _by_channel(shooting)
    size = 2 * n
    frequency = np.fft.rfftfreq(size, 1.0 / window.rate)
    turns = frequency * 2.0 * np.pi / shooting.frequency
    allowed = np.abs(turns - np.round(turns)) > np.where(turns < _HIGH, _APART, _APART_HIGH)
    allowed &= (turns > _APART) & (frequency < 0.49 * window.rate)
    if np.count_nonzero(allowed) < 16:
        return None
    taper = np.hanning(n)
    powers = {
        c: np.abs(np.fft.rfft(values * taper, size)) ** 2 / np.sum(taper**2) for c, values in left.items()
    }
    for power in powers.values():
        power /= max(1.0, float(np.median(power[allowed])) / np.log(2.0))
    channel = max(powers, key=lambda c: float(np.max(powers[c][allowed])))
    at = int(np.argmax(np.where(allowed, powers[channel], 0.0)))
    peak = float(powers[channel][at])
    if peak < np.log(len(frequency) * len(powers) / 0.01):
        return None
    near = slice(max(at - 2, 0), at + 3)
    wave = np.exp(-2j * np.pi * frequency[at] * np.arange(n) / window.rate)
    amplitude = 2.0 * abs(np.sum(left[channel] * taper * wave)) / np.sum(taper) * window.sigma[channel]
    return ResidualTone(
        Estimate(float(frequency[at]), window.rate / n, "Hz"),
        float(amplitude),
        channel,
        tuple(
            c for c in window.channels if len(window.channels) > 1 and float(np.max(powers[c][near])) > _SEEN
        ),
        float(np.sqrt(2.0 * peak)),
        _is_no_motion(window, channel, powers, at, 2.0 * np.pi * float(frequency[at])),
    )


def _is_no_motion(window: FitWindow, channel: str, powers: dict[str, Array], at: int, omega: float) -> bool:
    near = slice(max(at - 2, 0), at + 3)
    if float(powers[channel][at]) < 0.5 * float(np.max(powers[channel])):
        return False
    for other in window.channels:
        if other == channel:
            continue
        ratio = (
            omega ** (CHANNELS.index(other) - CHANNELS.index(channel))
            * window.sigma[channel]
            / window.sigma[other]
        )
        expected = float(powers[channel][at]) * ratio**2
        if expected > _EXPECTED and float(np.max(powers[other][near])) < 0.25 * expected:
            return True
    return False


def _by_channel(shooting: MultipleShooting) -> dict[str, Array]:
    """What the tracked model leaves with the states free, per channel on the window's clock, in units of the noise."""
    left = shooting.without_states(shooting.misfit[:, None])[:, 0]
    window = shooting.window
    series = {c: np.zeros(len(window)) for c in window.channels}
    for segment in shooting.segments:
        at = segment.rows.start
        for channel in window.channels:
            samples = np.flatnonzero(window.used[channel][segment.start : segment.stop]) + segment.start
            series[channel][samples] = left[at : at + len(samples)]
            at += len(samples)
    return series
