"""Rest: how still the channels are before the release, and so their noise."""

from dataclasses import dataclass

import numpy as np

from daq.recording import MOTIONS, Array, Channel

SHARE_OF_RANGE = 0.01
QUIET_S = 0.25
QUIET_SAMPLES = 8


@dataclass(frozen=True, eq=False)
class Rest:
    """The noise (standard deviation) of each channel at rest, shape (channels,), channel's unit."""

    noise: Array
    samples: int


def smallest_motion(channel: Channel, level: float | None = None) -> float:
    """Return the swing in the channel's unit below which nothing is taken for a release.

    `level` when given, else one per cent of the range, 0 when the range is unknown.
    """
    if level is not None:
        return level
    if channel.low is None or channel.high is None or not np.isfinite(channel.high - channel.low):
        return 0.0
    return SHARE_OF_RANGE * abs(channel.high - channel.low)


def is_still(channel: Channel, samples: Array, level: float | None = None) -> bool:
    """Check whether one channel, shape (n,), shows noise only: no drift or swing beyond its white part."""
    white = float(np.median(np.abs(np.diff(samples)))) / 0.6745 / np.sqrt(2)
    allowed = max(3 * white, channel.resolution or 0.0, 0.1 * smallest_motion(channel, level))
    return bool(samples.std() <= allowed)


class RestPeriod:
    """Feed it blocks; `rest` is there once 0.25 s were still, and `complete` once `seconds` were."""

    def __init__(
        self, channels: tuple[Channel, ...], rate: float, seconds: float, level: float | None = None
    ) -> None:
        self.rest: Rest | None = None
        self._channels = channels
        self._level = level
        self._quiet = max(round(QUIET_S * rate), QUIET_SAMPLES)
        self._wanted = max(round(seconds * rate), self._quiet)
        self._samples: Array = np.empty((len(channels), 0))

    @property
    def complete(self) -> bool:
        """Whether the mass was still for the whole period."""
        return self.rest is not None and self.rest.samples >= self._wanted

    @np.errstate(over="ignore", invalid="ignore")  # numbers of a board may be anything
    def feed(self, samples: Array) -> None:
        """Take a block, shape (channels, n); motion starts the period again."""
        self._samples = np.concatenate((self._samples, samples), axis=1)[:, -self._wanted :]
        n = self._samples.shape[1]
        if n < self._quiet:
            return
        if not self._still(self._samples[:, -self._quiet :]):
            self._samples = self._samples[:, -self._quiet + 1 :]
            return
        if not self._still(self._samples):
            self._samples = self._samples[:, -self._quiet :]
        self.rest = Rest(self._samples.std(axis=1), self._samples.shape[1])

    def _still(self, samples: Array) -> bool:
        pairs = zip(self._channels, samples, strict=True)
        return all(is_still(c, row, self._level_of(c)) for c, row in pairs if c.quantity in MOTIONS)

    def _level_of(self, channel: Channel) -> float | None:
        return self._level if channel.quantity == primary(self._channels) else None


def primary(channels: tuple[Channel, ...]) -> str | None:
    """Return the quantity by which a release is seen first: displacement, velocity, then acceleration."""
    present = {channel.quantity for channel in channels}
    return next((quantity for quantity in MOTIONS if quantity in present), None)
