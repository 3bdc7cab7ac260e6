"""The live scope: the newest seconds of the channel that triggers, with its zero, its noise and the trigger level."""

import time
from collections import deque
from dataclasses import dataclass

import numpy as np

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
        self._kept: deque[tuple[float, float]] = deque()
        self._rest: list[float] = []
        self._state, self._since = "", time.monotonic()
        self._seen = 0
        self._last = time.monotonic()

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
        now = time.monotonic()
        row = samples[self._row]
        if self._state == "resting":
            self._rest = [*self._rest, *row.tolist()][-2000:]
        moments = np.linspace(self._last, now, len(row) + 1)[1:]
        self._kept.extend(zip(moments.tolist(), row.tolist(), strict=True))
        self._last = now
        while self._kept and self._kept[0][0] < now - SHOWN_S:
            self._kept.popleft()

    def scope(self) -> Scope:
        """Choose the points to draw; extremes are kept where there are more samples than points."""
        channel = self._channel
        if channel is None:
            return Scope()
        factor, unit = scale_as_recorded(channel.quantity, channel.unit)
        zero, noise = (None, None) if len(self._rest) < 8 else (np.median(self._rest), np.std(self._rest))
        level = None
        if noise is not None:
            asked = self._settings.trigger_level
            level = smallest_motion(channel, asked)
            if asked is None:
                level = max(level, TIMES_NOISE * float(noise), TIMES_RESOLUTION * (channel.resolution or 0.0))
        return Scope(
            channel.name,
            typeset(unit),
            tuple((round(t - self._last, 3), float(f"{y * factor:.5g}")) for t, y in _extremes(self._kept)),
            zero=None if zero is None else float(zero) * factor,
            noise=None if noise is None else float(noise) * factor,
            level=None if level is None else level * factor,
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


def _extremes(kept: deque[tuple[float, float]]) -> list[tuple[float, float]]:
    points = list(kept)
    step = len(points) // POINTS
    if step < 2:
        return points
    found: list[tuple[float, float]] = []
    for start in range(0, len(points), 2 * step):
        part = points[start : start + 2 * step]
        ends = sorted({min(part, key=lambda p: p[1]), max(part, key=lambda p: p[1])})
        found += ends
    return found
