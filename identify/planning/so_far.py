"""The releases so far as one hypothesis explains them, to be fitted together with one that is only simulated."""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array
from identify.fitting.levenberg_marquardt import Minimum, minimise
from identify.fitting.parameter_layout import Unknown
from identify.fitting.problem import Problem
from identify.model.parameter_id import ParameterId
from identify.planning.hypotheses import Hypothesis
from identify.preprocessing.fit_window import FitWindow

_STEPS, _GAIN = 8, 0.2
"""Most steps of a refit, and the gain of chi-square that ends it: evidence need not be known to a tenth of a nat."""


@dataclass(frozen=True, eq=False)
class SoFar:
    """A `hypothesis` fitted to a few readings a cycle of the releases so far; `cost` is its chi-square."""

    hypothesis: Hypothesis
    windows: tuple[FitWindow, ...]
    theta: Array
    cost: float

    @classmethod
    def of(cls, one: Hypothesis) -> "SoFar":
        """Refit a hypothesis to fewer readings."""
        windows = tuple(window.at_few_readings(one.fit.frequency) for window in one.fit.windows)
        begun = {_of_window(u): float(x) for u, x in zip(one.fit.unknowns, one.fit.theta, strict=True)}
        end = _refitted(one, windows, begun)
        return cls(one, windows, end.theta, end.cost)

    def costs_more(self, own: Problem, centre: Array, readings: dict[str, Array]) -> float:
        """Return the rise of chi-square with one more record, whose own unknowns begin at `centre`.

        `own` is the problem of that record alone, whose window gets the `readings`.
        """
        last = 1 + max(one.release for one in self.windows)
        new = own.windows[0].with_(readings=readings, release=last, own_linear=self.windows[0].own_linear)
        known = zip(self.hypothesis.fit.unknowns, self.theta, strict=True)
        begun = {_of_window(u): float(x) for u, x in known}
        for u, x in zip(own.unknowns, centre, strict=True):
            if u.window == 0:
                begun[_of_window(u)[0], len(self.windows)] = float(x)
        return _refitted(self.hypothesis, (*self.windows, new), begun).cost - self.cost


def _of_window(unknown: Unknown) -> tuple[ParameterId, int]:
    """Return what an unknown is in its window, and which window that is: the same however many windows there are."""
    return unknown.id.of_release(0, 1), unknown.window


def _refitted(
    one: Hypothesis, windows: tuple[FitWindow, ...], begun: dict[tuple[ParameterId, int], float]
) -> Minimum:
    """Refit a hypothesis, 0 where it does not begin at a value, in the ranges within which each effect keeps its name."""
    problem = Problem(one.fit.model, windows, one.fit.frequency, coarse=True)
    problem.high = np.minimum(problem.high, [one.reach.get(u.name, np.inf) for u in problem.unknowns])
    start = np.array([begun.get(_of_window(u), 0.0) for u in problem.unknowns])
    return minimise(problem, start, steps=_STEPS, tolerance=_GAIN)
