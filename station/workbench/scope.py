"""The live scope: the newest seconds of the channel that triggers, with its zero, its noise and the trigger level."""

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from daq.capture import CaptureSettings
from daq.recording import Array, Channel
from daq.rest_detection import primary, smallest_motion
from daq.trigger import TIMES_NOISE, TIMES_RESOLUTION
from station.text.numbers import scale_as_recorded, typeset

SHOWN_S = 8.0
POINTS = 300


@dataclass(frozen=True)
class Scope:
    """What the scope draws: pairs of (time in s, value) in `unit`, oldest first.

    `zero`, `noise` (standard deviation at rest) and `level` (the swing that counts as a release) are in `unit`, None
    while they are not known; `left_s` is how long the present state lasts at most.
    """

    channel: str = ""
    unit: str = ""
    points: tuple[tuple[float, float], ...] = ()
    zero: float | None = None
    noise: float | None = None
    level: float | None = None
    left_s: float | None = None


class ScopeTrace:
    """Gathers what a capture sees; `scope` is what to draw now."""

    def __init__(self, settings: CaptureSettings) -> None:
        self._settings = settings
        self._row = 0
        self._channel: Channel | None = None
        self._times, self._values, self._rest = np.zeros(0), np.zeros(0), np.zeros(0)
        self._state, self._since = "", time.monotonic()
        self._last = self._since

    def connected(self, channels: tuple[Channel, ...]) -> None:
        """Note the channels; the one that triggers is shown."""
        wanted = primary(channels)
        self._row = next((i for i, c in enumerate(channels) if c.quantity == wanted), 0)
        self._channel = channels[self._row] if channels else None

    def state(self, name: str) -> None:
        """Note where the capture stands."""
        if name != self._state:
            self._state, self._since = name, time.monotonic()

    def block(self, samples: Array) -> None:
        """Keep samples, shape (channels, n); they are spread over the time since the block before."""
        if self._channel is None or samples.shape[1] == 0:
            return
        now, row = time.monotonic(), samples[self._row]
        if self._state == "resting":
            self._rest = np.append(self._rest, row)[-2000:]
        times = np.append(self._times, np.linspace(self._last, now, len(row) + 1)[1:])
        new = np.searchsorted(times, now - SHOWN_S)
        self._times, self._values, self._last = times[new:], np.append(self._values, row)[new:], now

    def scope(self) -> Scope:
        """Choose the points to draw; extremes are kept where there are more samples than points."""
        channel = self._channel
        if channel is None:
            return Scope()
        factor, unit = scale_as_recorded(channel.quantity, channel.unit)
        zero = noise = level = None
        if len(self._rest) >= 8:
            zero, noise = factor * float(np.median(self._rest)), factor * float(np.std(self._rest))
            asked = self._settings.trigger_level
            level = factor * smallest_motion(channel, asked)
            if asked is None:
                resolution = factor * (channel.resolution or 0.0)
                level = max(level, TIMES_NOISE * noise, TIMES_RESOLUTION * resolution)
        shown = _extremes(self._values)
        times, values = self._times[shown] - self._last, self._values[shown] * factor
        return Scope(
            channel.name,
            typeset(unit),
            tuple((round(t, 3), float(f"{y:.5g}")) for t, y in zip(times, values, strict=True)),
            zero=zero,
            noise=noise,
            level=level,
            left_s=self._left(),
        )

    def _left(self) -> float | None:
        lasts = {
            "resting": self._settings.rest_s,
            "armed": self._settings.trigger_timeout_s,
            "triggered": self._settings.duration_s,
            "recording": self._settings.duration_s,
        }.get(self._state)
        return None if lasts is None else max(0.0, lasts - (time.monotonic() - self._since))


def _extremes(values: Array) -> NDArray[np.intp]:
    """Choose samples in order: all where they are few, else the smallest and the largest of each part."""
    if len(values) < 2 * POINTS:
        return np.arange(len(values))
    parts = np.array_split(np.arange(len(values)), POINTS // 2)
    return np.unique([part[find(values[part])] for part in parts for find in (np.argmin, np.argmax)])
