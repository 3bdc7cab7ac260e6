"""The releases so far as one hypothesis explains them, to be fitted together with one that is only simulated."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from identify.arrays import Array
from identify.fitting.fit import Fit
from identify.fitting.levenberg_marquardt import minimise
from identify.fitting.problem import Problem
from identify.planning.hypotheses import Hypothesis
from identify.preprocessing.fit_window import FitWindow

_STEPS, _GAIN = 8, 0.2
"""Most steps of a refit, and the gain of chi-square that ends it: evidence need not be known to a tenth of a nat."""


@dataclass(frozen=True, eq=False)
class SoFar:
    """A hypothesis fitted to a few readings a cycle of the releases so far; `cost` is its chi-square."""

    fit: Fit
    windows: tuple[FitWindow, ...]
    theta: Array
    cost: float
    reach: Mapping[str, float]

    @classmethod
    def of(cls, one: Hypothesis) -> "SoFar":
        """Refit a hypothesis to fewer readings."""
        found = one.fit
        w = found.frequency
        windows = tuple(one.at_few_readings(w) for one in found.windows)
        problem = Problem(found.model, windows, w, coarse=True)
        _bound(problem, one.reach)
        end = minimise(problem, problem.theta(found.point), steps=_STEPS, tolerance=_GAIN)
        return cls(found, windows, end.theta, end.cost, one.reach)

    def costs_more(self, own: Problem, centre: Array, readings: dict[str, Array]) -> float:
        """Return the rise of chi-square with one more record, whose own unknowns begin at `centre`.

        `own` is the problem of that record alone, whose window gets the `readings`.
        """
        last = 1 + max(one.release for one in self.windows)
        new = own.windows[0].with_(readings=readings, release=last, own_linear=self.windows[0].own_linear)
        problem = Problem(self.fit.model, (*self.windows, new), self.fit.frequency, coarse=True)
        _bound(problem, self.reach)
        start = problem.theta(self._names() | _names_of_last(own, centre, len(self.windows)))
        return minimise(problem, start, steps=_STEPS, tolerance=_GAIN).cost - self.cost

    def _names(self) -> dict[str, float]:
        """Rename the values as if there were one more window and release."""
        count, releases = len(self.windows) + 1, 2 + max(one.release for one in self.windows)
        values = {}
        for u, value in zip(self.fit.unknowns, self.theta.tolist(), strict=True):
            if u.window < 0:
                values[u.name] = value
            elif u.deviates >= 0:
                values[str(u.id.of_release(self.windows[u.window].release, releases))] = value
            else:
                values[str(u.id.of_release(u.window, count))] = value
        return values


def _names_of_last(own: Problem, centre: Array, place: int) -> dict[str, float]:
    """Rename the unknowns of one window as if it came after all others."""
    each = zip(own.unknowns, centre.tolist(), strict=True)
    return {str(u.id.of_release(place, place + 1)): value for u, value in each if u.window == 0}


def _bound(problem: Problem, reach: Mapping[str, float]) -> None:
    """Bound the unknowns of a problem to the ranges within which each effect keeps its name."""
    problem.high = np.minimum(problem.high, [reach.get(u.name, np.inf) for u in problem.unknowns])
