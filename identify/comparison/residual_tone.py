"""A line in what the tracked model leaves: a frequency that is not the motion's own."""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array
from identify.comparison.multiple_shooting import Tracking
from identify.preprocessing.fit_window import CHANNELS, Span

_APART = 0.3
_HIGH = 6.5
_APART_HIGH = 0.12
_SEEN = 12.0
_EXPECTED = 40.0


@dataclass(frozen=True)
class ResidualLine:
    """The strongest line: `frequency` Hz, `amplitude` in the unit of `channel`, `significance` in standard errors.

    `channels` are those of several in which it is seen. `sensor` is True when the other channel lacks it where a
    motion would have shown there, with the ratio w^2 of acceleration to displacement: then it is no motion.
    """

    frequency: float
    amplitude: float
    channel: str
    channels: tuple[str, ...]
    significance: float
    sensor: bool


def find_line(tracking: Tracking) -> ResidualLine | None:
    """Return the strongest line away from multiples of the motion's frequency, as far as chance is not its cause.

    The spectrum is measured against its own median where that is above the noise, so that a broad misfit is no
    line. Chance reaches the limit in 1 % of records.
    """
    span = tracking.span
    n = len(span)
    left = _by_channel(tracking)
    size = 2 * n
    frequency = np.fft.rfftfreq(size, 1.0 / span.rate)
    turns = frequency * 2.0 * np.pi / tracking.frequency
    allowed = np.abs(turns - np.round(turns)) > np.where(turns < _HIGH, _APART, _APART_HIGH)
    allowed &= (turns > _APART) & (frequency < 0.49 * span.rate)
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
    wave = np.exp(-2j * np.pi * frequency[at] * np.arange(n) / span.rate)
    amplitude = 2.0 * abs(np.sum(left[channel] * taper * wave)) / np.sum(taper) * span.sigma[channel]
    return ResidualLine(
        float(frequency[at]),
        float(amplitude),
        channel,
        tuple(c for c in span.channels if len(span.channels) > 1 and float(np.max(powers[c][near])) > _SEEN),
        float(np.sqrt(2.0 * peak)),
        _is_no_motion(span, channel, powers, at, 2.0 * np.pi * float(frequency[at])),
    )


def _is_no_motion(span: Span, channel: str, powers: dict[str, Array], at: int, omega: float) -> bool:
    near = slice(max(at - 2, 0), at + 3)
    if float(powers[channel][at]) < 0.5 * float(np.max(powers[channel])):
        return False
    for other in span.channels:
        if other == channel:
            continue
        ratio = (
            omega ** (CHANNELS.index(other) - CHANNELS.index(channel))
            * span.sigma[channel]
            / span.sigma[other]
        )
        expected = float(powers[channel][at]) * ratio**2
        if expected > _EXPECTED and float(np.max(powers[other][near])) < 0.25 * expected:
            return True
    return False


def _by_channel(tracking: Tracking) -> dict[str, Array]:
    """What the tracked model leaves with the states free, per channel on the span's clock, in units of the noise."""
    span = tracking.span
    left = tracking.without_states(tracking.misfit[:, None])[:, 0]
    series = {c: np.zeros(len(span)) for c in span.channels}
    for stretch in tracking.stretches:
        at = stretch.rows.start
        for channel in span.channels:
            used = np.flatnonzero(span.used[channel][stretch.start : stretch.stop]) + stretch.start
            series[channel][used] = left[at : at + len(used)]
            at += len(used)
    return series
