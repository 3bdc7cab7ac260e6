"""Stability: whether the same effect leads when the cycles of the releases are drawn again.

The regression on curves is linear, so that a resampling is a weight on each cycle. Cycles are drawn in blocks, with
replacement (Künsch 1989), since what a model leaves of one resembles what it leaves of the next. In each resampling
the laws are fitted, and their predictions judged, on the cycles that were drawn.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from identify.arrays import Array
from identify.curves.curve_regression import CurveRegression, Rows
from identify.curves.curve_search import CurveSearch
from identify.curves.held_out import foretold_errors

RESAMPLINGS, _FEWEST = 50, 10
_WORK = 2000
"""Drawings, contenders, parts left out and parts fitted: what many releases take is kept to some tenths of a second."""

_SEED = 20


@dataclass(frozen=True)
class Contender:
    """A law that may lead: its `column`, the columns that it is fitted with, and the rows with its own corrections."""

    column: int
    columns: tuple[int, ...]
    rows: Sequence[Rows]


class _Drawn(CurveRegression):
    """A regression in which point i of curve r counts `counts[r][i]` times, in fits and in errors.

    What does not depend on the drawing is taken from the `whole`; `sides` are the rows of all contenders, whitened.
    """

    def __init__(self, whole: "_Contest", counts: Sequence[Array]) -> None:
        vars(self).update(vars(whole))
        self.sides, self.counts = whole.sides, tuple(counts)
        vars(self).pop("_normal", None)
        self.each = tuple(np.concatenate([c[1:], c[1:], c]) for c in counts)

    def _cross(self, release: int, values: Array) -> Array:
        return np.asarray((self._stack_of[release] * self.each[release][:, None]).T @ values)

    def _right(self, release: int, rows: Rows) -> Array:
        return self._cross(release, self.sides[rows])

    def _counted(self, release: int) -> Array:
        power = self.counts[release] * self.curves[release].amplitude ** 2
        return np.asarray(power / np.sum(power))


class _Contest(CurveRegression):
    """The regression on the laws of some contenders, with what all drawings share."""

    def __init__(self, of: CurveRegression, used: Sequence[int], rows: Iterable[Sequence[Rows]]) -> None:
        super().__init__(of.curves, [of.laws[c] for c in used], of.frequency)
        self.place = {column: at for at, column in enumerate(used)}
        self.sides = {
            one: self._whitened(i, one.loss, one.stiffness, one.centre)
            for several in rows
            for i, one in enumerate(several)
        }
        assert len(self._stack_of) == len(self._scatters)  # made here, once for all drawings


def drawn(
    of: CurveRegression, used: Sequence[int], rows: Iterable[Sequence[Rows]], counts: Sequence[Array]
) -> CurveRegression:
    """Return the regression on the `used` columns in which point i of curve r counts `counts[r][i]` times.

    The laws become columns 0, 1, ...; only the given `rows` can be fitted.
    """
    return _Drawn(_Contest(of, used, rows), counts)


def leaders(
    search: CurveSearch,
    contenders: Sequence[Contender],
    before: Contender,
    channel: str,
    choose: Callable[[Mapping[int, float], float], int | None],
) -> tuple[int | None, ...]:
    """Return the column that leads in each of some resamplings, 50 or, with many releases, fewer; None where none does.

    `before` are the columns and rows without any of the contenders. `choose` names the leader from the error of
    prediction of each contender, by its column, and the error before, in % of the motion, of one kind (`channel`).
    """
    everyone = (*contenders, before)
    used = sorted({c for one in everyone for c in one.columns})
    contest = _Contest(search.regression, used, [one.rows for one in everyone])
    random = np.random.default_rng(_SEED)
    parts = range(len(search.parts))
    counted = tuple(parts[1:] if search.one_record else parts)
    work = len(everyone) * len(counted) * (1 + len(search.parts))
    found = []
    for _ in range(min(RESAMPLINGS, max(_WORK // work, _FEWEST))):
        counts = [_blocks(random, len(curve)) for curve in search.parts]
        regression = _Drawn(contest, counts)
        errors = {
            one.column: _mean(regression, one, contest.place, counted, channel, search.one_record)
            for one in everyone
        }
        without = errors.pop(before.column)
        found.append(choose(errors, without))
    return tuple(found)


def _mean(
    regression: CurveRegression,
    one: Contender,
    place: Mapping[int, int],
    counted: Sequence[int],
    channel: str,
    one_record: bool,
) -> float:
    columns = tuple(place[c] for c in one.columns)
    errors = foretold_errors(regression, columns, one.rows, counted, one_record=one_record)
    return float(np.sqrt(np.mean([getattr(error, channel) ** 2 for error in errors])))


def _blocks(random: np.random.Generator, points: int) -> Array:
    """Return how often each point of a curve is drawn, in blocks whose length is the root of their number, (points,)."""
    length = max(round(np.sqrt(points)), 1)
    first = random.integers(0, points - length + 1, -(-points // length))
    counts = np.zeros(points)
    for start in first:
        counts[start : start + length] += 1.0
    return counts
