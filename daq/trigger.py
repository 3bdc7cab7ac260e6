"""Rest and release: how still the channels are before it, and the trigger. A release is what free swings follow.

A pull is one slow swing, a bump of the table a small or short one, an unsteady grip an uneven one, so the
trigger waits for three swings that shrink at an even period, and then looks back for the sample at which
the motion began. Nothing is lost by waiting: every sample is kept from START on.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from math import isnan

import numpy as np

from daq.recording import MOTIONS, Array, Channel

SHARE_OF_RANGE = 0.01
QUIET_S = 0.25
QUIET_SAMPLES = 8
TIMES_NOISE = 30.0
TIMES_RESOLUTION = 10.0
EDGE_TIMES_NOISE = 5.0
EDGE_SHARE = 0.001
REGULAR = 3
GROWTH = 1.1
SHRINK = 0.15
UNEVEN = 1.67


def smallest_motion(channel: Channel, level: float | None) -> float:
    """Return the swing in the channel's unit below which nothing is taken for a release.

    `level` when given, else one per cent of the range, 0 when the range is unknown.
    """
    if level is not None:
        return level
    if channel.low is None or channel.high is None or not np.isfinite(channel.high - channel.low):
        return 0.0
    return SHARE_OF_RANGE * abs(channel.high - channel.low)


def is_still(channel: Channel, samples: Array, level: float | None) -> bool:
    """Check whether one channel, shape (n,), shows noise only: no drift or swing beyond its white part."""
    white = float(np.median(np.abs(np.diff(samples)))) / 0.6745 / np.sqrt(2)
    allowed = max(3 * white, channel.resolution or 0.0, 0.1 * smallest_motion(channel, level))
    return bool(samples.std() <= allowed)


class RestPeriod:
    """Feed it blocks; `noise` is there once 0.25 s were still, and `complete` once `seconds` were.

    It is the standard deviation of each channel at rest, shape (channels,), in the channel's unit.
    """

    def __init__(
        self, channels: tuple[Channel, ...], rate: float, seconds: float, level: float | None = None
    ) -> None:
        self.noise: Array | None = None
        self.complete = False
        self._channels = channels
        self._level = level
        self._quiet = max(round(QUIET_S * rate), QUIET_SAMPLES)
        self._wanted = max(round(seconds * rate), self._quiet)
        self._samples: Array = np.empty((len(channels), 0))

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
        self.noise = self._samples.std(axis=1)
        self.complete = self._samples.shape[1] >= self._wanted

    def _still(self, samples: Array) -> bool:
        pairs = [(c, row) for c, row in zip(self._channels, samples, strict=True) if c.quantity in MOTIONS]
        levels = {primary(self._channels): self._level}
        return all(is_still(channel, row, levels.get(channel.quantity)) for channel, row in pairs)


def primary(channels: tuple[Channel, ...]) -> str | None:
    """Return the quantity by which a release is seen first: displacement, velocity, then acceleration."""
    present = {channel.quantity for channel in channels}
    return next((quantity for quantity in MOTIONS if quantity in present), None)


@dataclass(frozen=True)
class Turn:
    """A turning point: sample index and value."""

    index: int
    value: float


@dataclass(frozen=True)
class FreeOscillation:
    """Swings that shrink at an even period: `turns` from the first of them on, `half_period` in samples.

    `crossing` is the sample at which the first of them was half done.
    """

    turns: tuple[Turn, ...]
    crossing: int
    half_period: float

    @property
    def size(self) -> float:
        """The first swing from turn to turn."""
        return abs(self.turns[1].value - self.turns[0].value)


class TurningPoints:
    """The turning points of one channel that are at least a threshold apart (channel's unit).

    `history` gives samples `first` to `stop - 1` of it again, NaN where one is missing.
    """

    def __init__(self, history: Callable[[int, int], Array]) -> None:
        self._turns: list[Turn] = []
        self._low = self._high = Turn(-1, float("nan"))
        self._direction = 0
        self._history = history

    def feed(self, first: int, samples: Array, threshold: float) -> FreeOscillation | None:
        """Take samples, shape (n,), from index `first` on; return a free oscillation once three swings show it."""
        found = None
        for index, value in enumerate(samples.tolist(), first):
            if not isnan(value) and self._step(index, value, threshold):
                found = self._regular() or found
        return found

    def _step(self, index: int, value: float, threshold: float) -> bool:
        """Take one sample; return whether a turning point before it is now certain."""
        if not value <= self._high.value:  # the first is NaN
            self._high = Turn(index, value)
        if not value >= self._low.value:
            self._low = Turn(index, value)
        for direction, turn in ((-1, self._high), (1, self._low)):
            if direction != self._direction and abs(value - turn.value) > threshold:
                self._direction = direction
                self._low = self._high = Turn(index, value)
                self._turns = [*self._turns[-REGULAR:], turn]
                return True
        return False

    def _crossing(self, before: Turn, after: Turn) -> int:
        """The last sample before `after` on the near side of the middle between the two."""
        path = self._history(before.index, after.index)
        middle = (before.value + after.value) / 2
        near = path <= middle if after.value > before.value else path > middle
        return before.index + int(np.flatnonzero(near).max(initial=0))

    def _regular(self) -> FreeOscillation | None:
        """Return the last three swings if they shrink and their half periods agree."""
        if len(self._turns) <= REGULAR:
            return None
        values = [turn.value for turn in self._turns]
        sizes = [abs(b - a) for a, b in pairwise(values)]
        if not all(SHRINK * a <= b <= GROWTH * a for a, b in pairwise(sizes)):
            return None
        crossings = [self._crossing(a, b) for a, b in pairwise(self._turns)]
        times = [b - a for a, b in pairwise(crossings)]
        if min(times) < 1 or max(times) > UNEVEN * min(times) + 2:
            return None
        return FreeOscillation(tuple(self._turns), crossings[0], sum(times) / len(times))


@dataclass(frozen=True)
class Triggered:
    """The release as the station saw it: `sample` is the first that moves, `channel` the one that showed it."""

    sample: int
    channel: str
    half_period_s: float


def threshold(channel: Channel, noise: float, level: float | None = None) -> float:
    """Return the swing from which on a channel may show a release; it, `noise` at rest and a stated `level` in its unit."""
    smallest = smallest_motion(channel, level)
    if level is not None:
        return max(smallest, 6 * noise)
    return max(smallest, TIMES_NOISE * noise, TIMES_RESOLUTION * (channel.resolution or 0.0))


class Trigger:
    """Feed it blocks from rest on; it returns the release once three free swings have followed it.

    `noise` is that of a `RestPeriod`, and may be set again after a longer one: nothing that was seen is forgotten.
    `history` gives samples `first` to `stop - 1` again, shape (channels, n), NaN where one is missing.
    """

    def __init__(
        self,
        channels: tuple[Channel, ...],
        rate: float,
        noise: Array,
        history: Callable[[int, int], Array],
        level: float | None = None,
    ) -> None:
        self._channels = channels
        self._rate = rate
        self._level = level
        self._history = history
        self._since: int | None = None
        self._rows = [i for i, channel in enumerate(channels) if channel.quantity in MOTIONS]
        self._rows.sort(key=lambda i: MOTIONS.index(channels[i].quantity))
        self.noise = noise
        self._swings = {row: TurningPoints(partial(self._part, row)) for row in self._rows}

    def _threshold(self, row: int) -> float:
        channel = self._channels[row]
        level = self._level if channel.quantity == primary(self._channels) else None
        return threshold(channel, float(self.noise[row]), level)

    @np.errstate(over="ignore", invalid="ignore")  # numbers of a board may be anything
    def feed(self, first: int, samples: Array) -> Triggered | None:
        """Take a block, shape (channels, n), from sample index `first` on; holes are allowed."""
        self._since = first if self._since is None else self._since
        for row in self._rows:
            found = self._swings[row].feed(first, samples[row], self._threshold(row))
            if found is not None and self._counts(row, found):
                return Triggered(
                    self._onset(row, found),
                    self._channels[row].name,
                    found.half_period / self._rate,
                )
        return None

    def _counts(self, row: int, found: FreeOscillation) -> bool:
        """A velocity or acceleration counts beside a displacement only if it means a motion large enough.

        So a table that rings at 20 Hz does not trigger, and a displacement sensor that is dead does not
        keep the trigger from coming.
        """
        main = self._rows[0]
        steps = MOTIONS.index(self._channels[row].quantity) - MOTIONS.index(self._channels[main].quantity)
        omega = np.pi * self._rate / found.half_period
        return bool(found.size / omega**steps > self._threshold(main))

    def _onset(self, row: int, found: FreeOscillation) -> int:
        """Return the first sample that moves, by the earlier of this channel and the acceleration."""
        half = max(found.half_period, 1.0)
        sample = self._begin(row, found, half)
        for other in self._rows:
            if self._channels[other].quantity == "acceleration" and other != row:
                earlier = self._leave(
                    other, sample - round(half), sample - round(half / 4), sample + round(half / 2)
                )
                if sample - half / 2 < earlier < sample:
                    sample = earlier
        return max(sample, 0)

    def _begin(self, row: int, found: FreeOscillation, half: float) -> int:
        """Where this channel leaves the place it was held at, or the place it was struck at."""
        turn, crossing = found.turns[0], found.crossing
        before = self._at(row, crossing - round(half))
        was_held = np.isnan(before) or abs(before - turn.value) < 0.25 * found.size
        if was_held:
            return self._leave(row, crossing - round(1.5 * half), crossing - round(0.75 * half), crossing)
        return self._leave(row, turn.index - round(2.5 * half), turn.index - round(half), turn.index)

    def _leave(self, row: int, start: int, stop: int, moving: int) -> int:
        """Return the sample after the last one, before `moving`, that lies where `start` to `stop` lay."""
        start = max(start, self._since or 0)
        held = self._part(row, start, stop)
        held = held[np.isfinite(held)]
        away = np.abs(self._part(row, start, moving + 1) - np.median(held)) if len(held) else held
        if not np.isfinite(away).any():
            return moving
        farthest = int(np.nanargmax(away))
        peak = float(away[farthest])
        spread = float(np.median(np.abs(held - np.median(held)))) / 0.6745
        noise = min(max(float(self.noise[row]), spread), peak / 20)
        still = np.flatnonzero(away[:farthest] <= max(EDGE_TIMES_NOISE * noise, EDGE_SHARE * peak))
        return start + (int(still[-1]) + 1 if len(still) else 0)

    def _at(self, row: int, index: int) -> float:
        return float(self._part(row, index, index + 1)[0]) if index >= (self._since or 0) else float("nan")

    def _part(self, row: int, start: int, stop: int) -> Array:
        """Return samples `start` to `stop - 1` of one channel."""
        samples: Array = self._history(start, max(start, stop))[row]
        return samples
