"""What holds the mass, as true motion: it takes the mass to a displacement, holds it, and lets go at once or slowly.

All times are seconds of the holder's own clock, which goes on from capture to capture. A command acts on what no
sensor has been asked for yet, so at most `AHEAD_S` later than it came.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mocks.operator_sequence import LONGEST_S, SETTLED_S
from mocks.testbed import Bench, Release, simulate, simulate_channels

AHEAD_S = 1.0 / 16.0
SPEED_M_S = 0.020
SLOWLY_M_S = 0.005
PEAK = 1.875
"""Greatest speed of a way of least jerk over its mean speed."""
SHORTEST_S = 0.5
MAGNET_S = 0.002
"""How long the magnet takes to let go."""


@dataclass(frozen=True)
class Piece:
    """From `begin` on the mass stands at `place`, or is carried from there `way` far in `seconds`, or swings."""

    begin: float
    place: float = 0.0
    way: float = 0.0
    seconds: float = 1.0
    release: Release | None = None

    def observe(self, bench: Bench, early: np.ndarray, late: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the displacement at times `early` and the acceleration at times `late`; carried with least jerk."""
        if self.release is not None:
            return simulate_channels(bench, self.release, early - self.begin, late - self.begin)
        s = np.clip((early - self.begin) / self.seconds, 0.0, 1.0)
        u = self.place + self.way * s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
        s = np.clip((late - self.begin) / self.seconds, 0.0, 1.0)
        return u, self.way / self.seconds**2 * (60.0 * s - 180.0 * s**2 + 120.0 * s**3)


class Chunk(NamedTuple):
    """What an acquisition takes next, in seconds of the capture; one that begins with a release has it."""

    piece: Piece
    origin: float
    end: float
    release: Release | None
    released_at: float

    def observe(self, bench: Bench, early: np.ndarray, late: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the displacement at times `early` and the acceleration at times `late`."""
        return self.piece.observe(bench, early + self.origin, late + self.origin)


class Holder:
    """The actuator and the mass in it; displacements from `low` to `high`, m. `origin` is when the capture began."""

    def __init__(self, bench: Bench, low: float, high: float, release_s: float = MAGNET_S) -> None:
        self.bench = bench
        self.low = low
        self.high = high
        self.contact_is_open = False
        self.origin = 0.0
        self.released_at: float | None = None
        self._release_s = release_s
        self._course = [Piece(0.0)]
        self._seen = 0.0

    def take(self, place: float, at: float, slowly: bool = False) -> None:
        """Take the mass to `place`; one that still swings is taken once it has come to rest."""
        begin = max(at, self._seen)
        if self._piece(begin).release is not None:
            begin = self._course[-1].begin
        start = self._place(begin)
        fastest = SLOWLY_M_S if slowly else SPEED_M_S
        seconds = max(PEAK * abs(place - start) / fastest, SHORTEST_S)
        self._go_on(Piece(begin, start, place - start, seconds), Piece(begin + seconds, place))

    def let_go(self, at: float) -> None:
        """Let go at once."""
        begin = self.released_at = max(at, self._seen)
        release = Release(self._place(begin), 0.0, self._release_s)
        time = np.arange(0.0, LONGEST_S, 1.0 / 64.0)
        motion = simulate(self.bench, release, time)
        moving = np.nonzero(motion.velocity)[0]
        swings = min(float(time[moving[-1]]) + SETTLED_S if len(moving) else SETTLED_S, LONGEST_S)
        self._go_on(Piece(begin, release=release), Piece(begin + swings, float(motion.displacement[-1])))

    def arrived(self, at: float) -> bool:
        """Whether the mass is where it was to be taken."""
        return at >= self._course[-1].begin

    def rest(self, at: float) -> None:
        """Let the mass that swings be at rest from now on: nobody looks."""
        if self._piece(max(at, self._seen)).release is not None:
            self._go_on(Piece(max(at, self._seen), self._course[-1].place))

    def begin(self, at: float) -> None:
        """Note that a capture begins."""
        self.origin, self.released_at = at, None

    def capture(self) -> Iterator[Chunk]:
        """Yield the motion of one capture, chunk by chunk and without end."""
        self._seen = origin = self.origin
        while True:
            begin, piece = self._seen, self._piece(self._seen)
            self._seen = min([begin + AHEAD_S, *(p.begin for p in self._course if p.begin > begin)])
            new = piece.release if piece.begin == begin else None
            yield Chunk(piece, origin, self._seen - origin, new, begin - origin)

    def _go_on(self, *pieces: Piece) -> None:
        self._course = [p for p in self._course if p.begin < pieces[0].begin][-1:] + list(pieces)

    def _piece(self, at: float) -> Piece:
        return [p for p in self._course if p.begin <= at][-1]

    def _place(self, at: float) -> float:
        once = np.array([at])
        return float(self._piece(at).observe(self.bench, once, once)[0][0])
