"""Turning points of one channel, found as its samples come; motion below a threshold is ignored."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from math import isnan

import numpy as np

from daq.recording import Array

REGULAR = 3
GROWTH = 1.1
SHRINK = 0.15
UNEVEN = 1.67


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
    """The turning points of one channel that are at least `threshold` apart (channel's unit).

    `history` gives samples `first` to `stop - 1` of it again, NaN where one is missing.
    """

    def __init__(self, threshold: float, history: Callable[[int, int], Array]) -> None:
        self.threshold = threshold
        self._turns: list[Turn] = []
        self._crossings: list[int] = []
        self._low = self._high = Turn(-1, float("nan"))
        self._direction = 0
        self._history = history

    def feed(self, first: int, samples: Array) -> FreeOscillation | None:
        """Take samples, shape (n,), from index `first` on; return a free oscillation once three swings show it."""
        found = None
        for index, value in enumerate(samples.tolist(), first):
            if not isnan(value) and self._step(index, value):
                found = self._regular() or found
        return found

    def _step(self, index: int, value: float) -> bool:
        """Take one sample; return whether a turning point before it is now certain."""
        if self._low.index < 0:
            self._low = self._high = Turn(index, value)
        if value > self._high.value:
            self._high = Turn(index, value)
        if value < self._low.value:
            self._low = Turn(index, value)
        if self._direction >= 0 and self._high.value - value > self.threshold:
            return self._turn(self._high, -1, Turn(index, value))
        if self._direction <= 0 and value - self._low.value > self.threshold:
            return self._turn(self._low, 1, Turn(index, value))
        return False

    def _turn(self, turn: Turn, direction: int, now: Turn) -> bool:
        self._direction = direction
        if self._turns:
            self._crossings.append(self._crossing(self._turns[-1], turn))
        self._low = self._high = now
        self._turns = [*self._turns[-REGULAR:], turn]
        self._crossings = self._crossings[-REGULAR:]
        return True

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
        times = [b - a for a, b in pairwise(self._crossings)]
        if min(times) < 1 or max(times) > UNEVEN * min(times) + 2:
            return None
        return FreeOscillation(tuple(self._turns), self._crossings[0], sum(times) / len(times))
