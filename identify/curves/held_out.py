"""Held out: what laws that were fitted to some curves predict of the others.

With several releases each is left out in turn, and its linear spring and damper alone are refitted. One release is cut
in two at the geometric mean of its amplitudes: the large amplitudes predict the small ones, and back, nothing refitted.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from identify.curves.curve_regression import CurveRegression, MotionError, Rows, Strengths
from identify.curves.decay_curve import DecayCurve

_FEWEST = 5


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Errors of some laws: `predicted` one for each part that was left out.

    Of `one_record` cut in two the means count the small amplitudes, predicted from the large ones: the way back asks
    small amplitudes for what they hardly show.
    """

    strengths: Strengths
    predicted: tuple[MotionError, ...]
    one_record: bool

    @property
    def counted(self) -> tuple[MotionError, ...]:
        """The errors of prediction that means are taken of."""
        return self.predicted[1:] if self.one_record else self.predicted

    def mean(self, channel: str) -> float:
        """Return the rms over parts of one kind of error ("envelope", "phase", "centre", "motion"), % of the motion."""
        return float(np.sqrt(np.mean([getattr(error, channel) ** 2 for error in self.counted])))

    def typical(self, channel: str) -> float:
        """Return the median over the parts that were left out, % of the motion."""
        return float(np.median([getattr(error, channel) for error in self.counted]))

    def better(self, other: "HeldOut", channel: str) -> int:
        """Return on how many parts the prediction is better than another's."""
        pairs = zip(self.predicted, other.predicted, strict=True)
        return sum(getattr(mine, channel) < getattr(theirs, channel) for mine, theirs in pairs)


def cut_by_amplitude(curve: DecayCurve) -> tuple[DecayCurve, ...]:
    """Return the large, middle and small amplitudes of a curve, equal in ratio, one point in common between neighbours.

    Two parts where it is too short for three, the whole where it is too short for two.
    """
    size = np.log(curve.amplitude)
    for parts in (3, 2):
        if len(curve) <= parts * _FEWEST:
            continue
        levels = np.linspace(size.max(), size.min(), parts + 1)[1:-1]
        edges = [0, *(int(np.argmin(np.abs(size - level))) for level in levels), len(curve) - 1]
        for i in range(1, parts):
            edges[i] = max(edges[i], edges[i - 1] + _FEWEST)
        for i in range(parts - 1, 0, -1):
            edges[i] = min(edges[i], edges[i + 1] - _FEWEST)
        return tuple(curve.part(first, last + 1) for first, last in pairwise(edges))
    return (curve,)


def hold_out(
    regression: CurveRegression, columns: tuple[int, ...], rows: Sequence[Rows], *, one_record: bool
) -> HeldOut:
    """Return what some laws predict of each curve from the others, and their strengths when fitted to all."""
    everything = list(range(len(regression.curves)))
    predicted = []
    for left in everything if len(everything) > 1 else ():
        others = [i for i in everything if i != left]
        found = regression.solve(columns, others, rows, one_record=one_record)
        if not one_record:
            found = regression.predict(found, left, rows[left])
        predicted.append(regression.error(found.shared, columns, left, rows[left]))
    whole = regression.solve(columns, everything, rows, one_record=one_record)
    return HeldOut(whole, tuple(predicted), one_record)
