"""The decay curve: amplitude, phase and centre of one mode, cycle by cycle.

The amplitude curve: frequency and damping of one release against amplitude, each with its error.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from identify.arrays import Array

_ABOVE = 0.1
_COMES_BACK = 1.25
_LAST = 0.6
_STEADY = 0.1
_LONG_ENOUGH = 8
_FALLEN = 1.5
"""Largest amplitude over the largest of the late part from which on a free motion would have gone on to fall."""


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
        return np.sqrt(self.amplitude[1:]) * np.sqrt(self.amplitude[:-1])

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
    def beats(self) -> bool:
        """Whether the amplitude rises again by a quarter after it had fallen, which one free mode never does."""
        high = self.amplitude[self.amplitude > _ABOVE * self.amplitude.max()]
        later = np.maximum.accumulate(high[::-1])[::-1]
        return bool(np.max(later / high) > _COMES_BACK)

    @property
    def driven(self) -> bool:
        """Whether the amplitude grows, settles at a constant value, or beats about one, until the end.

        No free motion does: even where it beats, its largest amplitudes fall. One that only falls to a level may be free,
        and its damping fade. One that beats has thirds with a beat in each.
        """
        level, before = float(np.mean(self.late)), self.amplitude[: len(self) - len(self.late)]
        if len(self.late) < _LONG_ENOUGH or before.min() >= level:
            return False
        if self.grows:
            return True
        if not self.beats_late:
            return bool(np.ptp(before) > 2.0 * _STEADY * level)
        thirds = np.array_split(self.late, 3)
        alike = (
            np.ptp([measure(part) for part in thirds]) < _STEADY * level for measure in (np.mean, np.max)
        )
        fallen = before.max() > _FALLEN * self.late.max()
        return len(thirds[0]) >= _LONG_ENOUGH and all(alike) and bool(fallen)

    @property
    def grows(self) -> bool:
        """Whether the late part is larger than all before it, by a quarter."""
        return bool(self.late.max() > _COMES_BACK * self.amplitude[: len(self) - len(self.late)].max())

    @property
    def beats_late(self) -> bool:
        """Whether the amplitude varies over the last two fifths."""
        return bool(np.ptp(self.late) >= _STEADY * np.mean(self.late))

    @property
    def late(self) -> Array:
        """The amplitudes of the last two fifths."""
        return self.amplitude[round(_LAST * len(self)) :]

    def part(self, points: slice) -> Self:
        """Return some of the points."""
        arrays = ("time", "amplitude", "phase", "centre", "misfit")
        return replace(self, **{name: getattr(self, name)[points] for name in arrays})


_MOST_POINTS = 36
"""Points of a curve; the phase's error counts once a step, so that frequency is the surer the longer the steps are."""

_NEIGHBOURS = 9
THIRD_DIFFERENCES = 20.0
"""Variance of a third difference of independent values, in units of theirs: 1 + 9 + 9 + 1."""


@dataclass(frozen=True, eq=False)
class AmplitudeCurve:
    """Frequency (Hz) and damping against amplitude (m or rad) of one release, or of a model run in its place, (n,) each.

    `damping` is the equivalent viscous damping ratio, a pure number: a cycle loses the share 4 pi times it of the
    energy, and the logarithmic decrement is 2 pi times it (while it is small). `frequency_std` and `damping_std` are
    standard errors of each point, and zero of a model's. `release` is the release's place among those that were given.
    """

    release: int
    amplitude: Array
    frequency: Array
    damping: Array
    frequency_std: Array
    damping_std: Array

    def __len__(self) -> int:
        return len(self.amplitude)

    @classmethod
    def measured(cls, curve: DecayCurve, release: int) -> Self:
        """Compute frequency and damping of a measured curve between points, or, where it has many, over several points.

        The errors are found from the scatter of neighbouring points: the rms of their third differences over nine
        neighbours, over sqrt(20), as for independent errors: a smooth bend counts little. Errors of readings
        make neighbours err in opposite directions, which makes this up to 1.3 times too large; a drift slower than
        four points is not in it.
        """
        curve = curve.part(slice(None, None, max(1, -(-(len(curve) - 1) // _MOST_POINTS))))
        frequency, damping = curve.frequency / (2.0 * np.pi), curve.loss / (2.0 * curve.frequency)
        return cls(release, curve.between, frequency, damping, scatter(frequency), scatter(damping))

    @classmethod
    def predicted(cls, curve: DecayCurve, release: int) -> Self:
        """Compute frequency and damping of a model's curve over the same steps, without errors."""
        found = cls.measured(curve, release)
        return replace(found, frequency_std=np.zeros(len(found)), damping_std=np.zeros(len(found)))

    def down_to(self, amplitude: float) -> Self:
        """Keep the points whose amplitude is not below another curve's, m or rad."""
        kept = self.amplitude >= amplitude
        values = (self.amplitude, self.frequency, self.damping, self.frequency_std, self.damping_std)
        return type(self)(self.release, *(value[kept] for value in values))


def scatter(values: Array) -> Array:
    """Estimate the standard error of each of some values (n,) from the third differences around it; NaN below four."""
    if len(values) < 4:
        return np.full(len(values), np.nan)
    square = np.diff(values, 3) ** 2 / THIRD_DIFFERENCES
    width = min(_NEIGHBOURS, len(square))
    mean = np.convolve(square, np.ones(width) / width, "valid")
    place = np.clip(np.arange(len(values)) - 1 - width // 2, 0, len(mean) - 1)
    return np.asarray(np.sqrt(mean[place]))
