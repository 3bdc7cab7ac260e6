"""An operator at the bench: rest, pull, hold, let go; and again, as long as the station listens.

Each capture begins with the mass at rest. The next release of the sequence follows by itself a
second after the mass has come to rest. The next capture begins with the release after the first
one that this capture saw, and after the last of the sequence with the first again.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mocks.testbed import Bench, Release, simulate, simulate_channels

REST_S = 1.2
PULL_S = 1.0
HOLD_S = 1.3
FREE_S = 9.5
LONGEST_S = 12.0
SETTLED_S = 1.5
#: A bump of the table, in the middle of the hold: 18 Hz, 1 m/s^2, some 50 ms long.
BUMP_HZ = 18.0
BUMP_ACCELERATION = 1.0
BUMP_LENGTH_S = 0.03


@dataclass(frozen=True)
class Episode:
    """From rest to rest: begins at `start` (s of the capture) with the mass at `rest` (m)."""

    start: float
    rest: float
    release: Release | None
    released_at: float
    end: float
    number: int = -1
    bumped: bool = False

    def observe(self, bench: Bench, early: np.ndarray, late: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the displacement at times `early` and the acceleration at times `late`."""
        if self.release is None:
            return np.full(len(early), self.rest), np.zeros(len(late))
        u, a = simulate_channels(bench, self.release, early - self.released_at, late - self.released_at)
        held = early < self.released_at
        u[held] = self._before(early[held])[0]
        held = late < self.released_at
        a[held] = self._before(late[held])[1]
        return u, a

    def _before(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Displacement and acceleration until the release: rest, a pull of least jerk, hold."""
        assert self.release is not None
        s = np.clip((time - self.start - REST_S) / PULL_S, 0.0, 1.0)
        way = self.release.displacement - self.rest
        u = self.rest + way * s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
        a = way / PULL_S**2 * (60.0 * s - 180.0 * s**2 + 120.0 * s**3)
        if self.bumped:
            x = (time - (self.released_at - 0.5 * HOLD_S)) / BUMP_LENGTH_S
            w = 2.0 * math.pi * BUMP_HZ * BUMP_LENGTH_S
            size = BUMP_ACCELERATION / (2.0 * math.pi * BUMP_HZ) ** 2
            bell = size * np.exp(-0.5 * x * x)
            u = u + bell * np.cos(w * x)
            curve = (x * x - 1.0 - w * w) * np.cos(w * x) + 2.0 * x * w * np.sin(w * x)
            a = a + bell * curve / BUMP_LENGTH_S**2
        return u, a


class OperatorSequence:
    """The releases of a sequence; one instance lives through all captures."""

    def __init__(self, bench: Bench, releases: tuple[Release, ...], bumped: bool = False) -> None:
        self.bench = bench
        self.releases = releases
        self.bumped = bumped
        self._next = 0
        self._rest = 0.0

    def capture(self, random: np.random.Generator) -> Iterator[Episode]:
        """Yield the episodes of one capture, from its first instant on, without end."""
        start = 0.0
        for number in range(self._next, len(self.releases)):
            episode = self._episode(start, number, random)
            yield episode
            start = episode.end
            self._rest = self._rest_of(episode)
        while True:
            yield Episode(start, self._rest, None, math.inf, start + 1.0)
            start += 1.0

    def use_up(self, episode: Episode) -> None:
        """Note that a capture has seen this release: the next one begins with the one after."""
        self._next = (episode.number + 1) % len(self.releases)
        self._rest = self._rest_of(episode)

    def _episode(self, start: float, number: int, random: np.random.Generator) -> Episode:
        release = self.releases[number]
        at = start + REST_S + PULL_S + HOLD_S + random.uniform(0.0, 0.3)
        if release.velocity:
            release = Release(self._rest, release.velocity, release.release_time)
        time = np.arange(0.0, LONGEST_S, 1.0 / 64.0)
        moving = np.nonzero(simulate(self.bench, release, time).velocity)[0]
        stops = time[moving[-1]] if len(moving) else 0.0
        end = at + max(FREE_S, stops + SETTLED_S)
        return Episode(start, self._rest, release, at, end, number, self.bumped)

    def _rest_of(self, episode: Episode) -> float:
        assert episode.release is not None
        end = np.array([episode.end - episode.released_at])
        return float(simulate(self.bench, episode.release, end).displacement[0])


def parse_releases(text: str, release_times: Iterator[float]) -> tuple[Release, ...]:
    """Return the releases of `paper` or of a list: millimetres, or v0.4 for a velocity in m/s."""
    if text == "paper":
        text = "-25,-20,-15,-5,20,25,v0.45,v-0.35,v0.6"
    releases = []
    for item in text.split(","):
        try:
            if item.strip().startswith("v"):
                releases.append(Release(0.0, float(item.strip()[1:]), next(release_times)))
            else:
                releases.append(Release(float(item) * 1e-3, 0.0, next(release_times)))
        except ValueError:
            raise ValueError(
                f"a release is a displacement in mm (-25) or a velocity in m/s (v0.4), not {item!r}"
            ) from None
        if not releases[-1].displacement and not releases[-1].velocity:
            raise ValueError("a release of 0 moves nothing; give mm such as -25 or a velocity such as v0.4")
    return tuple(releases)
