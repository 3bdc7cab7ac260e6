"""How far a campaign is: one line that is written over in a terminal, plain lines elsewhere."""

import sys
import time
from collections.abc import Callable
from typing import TextIO

from station.output import WIDTH
from station.safe_text import harmless

EVERY_S = 10.0
REFRESH_S = 0.2
FEWEST_FOR_A_RATE = 3


class CampaignProgress:
    """Counts sessions and says how many are done, how fast, and how long the rest takes."""

    def __init__(
        self, total: int, stream: TextIO | None = None, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._total = total
        self._stream = stream if stream is not None else sys.stderr
        self._terminal = self._stream.isatty()
        self._clock = clock
        self._began = self._shown = clock()
        self._done = self._kept = self._failed = 0

    def kept(self, name: str) -> None:
        """Count a session that had been done before."""
        self._kept += 1

    def done(self, name: str) -> None:
        """Count a session that has been done."""
        self._done += 1
        self._show()

    def failed(self, name: str, reason: str) -> None:
        """Print at once that a session has no result, and why."""
        self._failed += 1
        self._erase()
        self._print(f"failed: {name}: {reason}")
        self._show()

    def end(self) -> None:
        """Print how it ended."""
        self._erase()
        self._print(self.line())

    def line(self) -> str:
        """Measure how far it is: "312/500 sessions, 4.1/s, 46 s left, 3 failed"."""
        here = min(self._done + self._kept + self._failed, self._total)
        parts = [f"{here}/{self._total} sessions"]
        if self._kept:
            parts.append(f"{self._kept} kept from before")
        seconds = self._clock() - self._began
        if self._done >= FEWEST_FOR_A_RATE and seconds > 0.0:
            rate = self._done / seconds
            parts.append(f"{rate:.3g}/s" if rate >= 1.0 else f"{1.0 / rate:.3g} s each")
            if here < self._total:
                parts.append(f"{duration((self._total - here) / rate)} left")
        if self._failed:
            parts.append(f"{self._failed} failed")
        return ", ".join(parts)

    def _show(self) -> None:
        now = self._clock()
        if now - self._shown < (REFRESH_S if self._terminal else EVERY_S):
            return
        self._shown = now
        if self._terminal:
            self._stream.write(f"\r{self.line()[: WIDTH - 1]:<{WIDTH - 1}}")
            self._stream.flush()
        else:
            self._print(self.line())

    def _erase(self) -> None:
        if self._terminal:
            self._stream.write(f"\r{'':<{WIDTH - 1}}\r")

    def _print(self, text: str) -> None:
        self._stream.write(f"{harmless(text)}\n")
        self._stream.flush()


def duration(seconds: float) -> str:
    """Return a time as people say it: "46 s", "12 min", "3.4 h"."""
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 6000.0 else f"{seconds / 3600.0:.1f} h"
