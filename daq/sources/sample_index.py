"""The index of each line's sample: from its counter, from its time stamp, or one after the other."""

import numpy as np

from daq.errors import BoardError, LinkLost

WRAPS = (1 << 8, 1 << 16, 1 << 32)
MOST_LOST = 1_000_000
_FOLLOWS = 0.05
_NEAR_THE_END = 0.9


class CountedIndex:
    """Indices from a counter that wraps round after 8, 16 or 32 bits."""

    def __init__(self) -> None:
        self._last: int | None = None
        self.index = -1

    def next(self, counter: float) -> int:
        """Return the index of the next line. Raises LinkLost where the counter restarts in between."""
        now = round(counter)
        step = 1 if self._last is None else now - self._last
        if self._last is not None and step <= 0:
            wrap = next((w for w in WRAPS if _NEAR_THE_END * w <= self._last < w and now < w), None)
            if wrap is None:
                raise LinkLost(
                    f"the counter went from {self._last} to {now}: the board restarted; what came before is kept"
                )
            step += wrap
        if step > MOST_LOST:
            raise BoardError(f"the counter jumps from {self._last} to {now}; is that column a counter?")
        self._last = now
        self.index += step
        return self.index


class StampedIndex:
    """Indices from time stamps (s) at a rate that is known nearly; it follows a slow drift between the two."""

    def __init__(self, rate: float, wrap_s: float) -> None:
        self._rate = rate
        self._wrap = wrap_s
        self._first: float | None = None
        self._last = 0.0
        self._phase = 0.0
        self.index = -1

    def next(self, stamp: float) -> tuple[int, float]:
        """Return the index of the next line and its time since the first, s. Raises LinkLost where time goes back."""
        if self._first is None:
            self._first = self._last = stamp
            self.index = 0
            return 0, 0.0
        if stamp < self._last:
            if self._last < _NEAR_THE_END * self._wrap:
                raise LinkLost(
                    f"the time stamps go back from {self._last:g} s to {stamp:g} s: the board restarted; what came "
                    "before is kept"
                )
            self._first -= self._wrap
        self._last = stamp
        time = stamp - self._first
        ideal = time * self._rate - self._phase
        step = max(round(ideal) - self.index, 1)
        if step > MOST_LOST:
            raise BoardError(f"the time stamps jump to {stamp:g} s; is that column the time?")
        self.index += step
        self._phase += _FOLLOWS * float(np.clip(ideal - self.index, -0.5, 0.5))
        return self.index, time
