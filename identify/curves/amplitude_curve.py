"""The amplitude curve: frequency and damping of one release against amplitude, each with its error."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from identify.arrays import Array
from identify.curves.decay_curve import DecayCurve

_MOST_POINTS = 36
"""Points of a curve; the phase's error counts once a step, so that frequency is the surer the longer the steps are."""

_NEIGHBOURS = 9
_THIRD_DIFFERENCES = 20.0
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
    def measured(cls, curve: DecayCurve, release: int = 0) -> Self:
        """Return what a measured curve shows from one point to the next, or, where it has many, some points on.

        The errors are found from the scatter of neighbouring points: the rms of their third differences over nine
        neighbours, over sqrt(20), as of values that err each for itself: a smooth bend counts little. Errors of readings
        make neighbours err in opposite directions, which makes this up to 1.3 times too large; a drift slower than
        four points is not in it.
        """
        curve = _thinned(curve)
        frequency, damping = _rates(curve)
        return cls(release, curve.between, frequency, damping, scatter(frequency), scatter(damping))

    @classmethod
    def predicted(cls, curve: DecayCurve, release: int = 0) -> Self:
        """Return what a model's curve shows over the same steps; without errors."""
        curve = _thinned(curve)
        frequency, damping = _rates(curve)
        return cls(release, curve.between, frequency, damping, np.zeros(len(damping)), np.zeros(len(damping)))

    def down_to(self, amplitude: float) -> Self:
        """Return the points whose amplitude is not below another's, m or rad."""
        kept = self.amplitude >= amplitude
        values = (self.amplitude, self.frequency, self.damping, self.frequency_std, self.damping_std)
        return type(self)(self.release, *(value[kept] for value in values))


def _rates(curve: DecayCurve) -> tuple[Array, Array]:
    return curve.frequency / (2.0 * np.pi), curve.loss / (2.0 * curve.frequency)


def _thinned(curve: DecayCurve) -> DecayCurve:
    """Return every second, third ... point of a curve that has many."""
    every = slice(None, None, max(1, -(-(len(curve) - 1) // _MOST_POINTS)))
    return DecayCurve(
        curve.time[every],
        curve.amplitude[every],
        curve.phase[every],
        curve.centre[every],
        curve.misfit[every],
        curve.has_centre,
        curve.lightness,
    )


def scatter(values: Array) -> Array:
    """Return the standard error of each of some values (n,), by the third differences around it; NaN below four."""
    if len(values) < 4:
        return np.full(len(values), np.nan)
    square = np.diff(values, 3) ** 2 / _THIRD_DIFFERENCES
    width = min(_NEIGHBOURS, len(square))
    mean = np.convolve(square, np.ones(width) / width, "valid")
    place = np.clip(np.arange(len(values)) - 1 - width // 2, 0, len(mean) - 1)
    return np.asarray(np.sqrt(mean[place]))
