"""The decay curve: amplitude, phase and centre of one mode, cycle by cycle."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from identify.arrays import Array

_ABOVE = 0.1
_COMES_BACK = 1.25
_LAST = 0.6
_STEADY = 0.1
_LONG_ENOUGH = 8


@dataclass(frozen=True, eq=False)
class DecayCurve:
    """Amplitude (m or rad), phase (rad) and centre of the oscillation (m or rad) at `time` s since the release, (n,) each.

    Readings of a velocity or an acceleration are divided by the frequency or its square; their centre says nothing about
    the displacement's, and `has_centre` is False. `misfit` is the rms of what
    the window's harmonic motion leaves of the reading, in units of the amplitude, (n,). All strengths are divided by an
    inertia that is `lightness` times this release's.
    """

    time: Array
    amplitude: Array
    phase: Array
    centre: Array
    misfit: Array
    has_centre: bool = True
    lightness: float = 1.0

    def __len__(self) -> int:
        return len(self.time)

    @property
    def step(self) -> Array:
        """Time from each point to the next, s, (n - 1,)."""
        return np.diff(self.time)

    @property
    def between(self) -> Array:
        """Geometric mean of the amplitudes of each point and the next, (n - 1,)."""
        return np.asarray(np.sqrt(self.amplitude[1:] * self.amplitude[:-1]))

    @property
    def clock(self) -> Array:
        """Time halfway between each point and the next, s since the release, (n - 1,)."""
        return 0.5 * (self.time[1:] + self.time[:-1])

    @property
    def loss(self) -> Array:
        """Equivalent viscous damping, 1/s, (n - 1,): -2 A'/A."""
        return np.asarray(-2.0 * np.diff(np.log(self.amplitude)) / self.step)

    @property
    def frequency(self) -> Array:
        """Angular frequency, rad/s, (n - 1,)."""
        return np.asarray(np.diff(self.phase) / self.step)

    @property
    def range(self) -> float:
        """Largest amplitude over the smallest."""
        return float(self.amplitude.max() / self.amplitude.min())

    @property
    def beats(self) -> bool:
        """Whether the amplitude comes back by a quarter after it had fallen, which one mode left alone never does."""
        high = self.amplitude[self.amplitude > _ABOVE * self.amplitude.max()]
        later = np.maximum.accumulate(high[::-1])[::-1]
        return bool(np.max(later / high) > _COMES_BACK)

    @property
    def driven(self) -> bool:
        """Whether the amplitude, after other values, keeps one of its own to the end: no free motion does."""
        first = round(_LAST * len(self))
        level = float(np.mean(self.amplitude[first:]))
        steady = np.ptp(self.amplitude[first:]) < _STEADY * level and len(self) - first >= _LONG_ENOUGH
        before = self.amplitude[:first]
        return bool(steady and np.ptp(before) > 2.0 * _STEADY * level and before.min() < level)

    def part(self, first: int, last: int) -> Self:
        """Return the points from `first` to before `last`."""
        cut = slice(first, last)
        return type(self)(
            self.time[cut],
            self.amplitude[cut],
            self.phase[cut],
            self.centre[cut],
            self.misfit[cut],
            self.has_centre,
            self.lightness,
        )
