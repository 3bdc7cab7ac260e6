"""Bars of the ladder: the residual on a logarithmic scale, with the noise as a line."""

import math

from station.results.ladder import KeptLadder

LEAST = 0.5
"""Reduced chi-square at which the bars begin, so that a model at the floor still has one."""


def share(chi_square: float | None, ladder: KeptLadder) -> tuple[float, float]:
    """Return the length of a bar and the place of the floor, in % of the track."""
    largest = max([step.error.chi2 or 1.0 for step in ladder.steps] + [2.0])
    whole = math.log(largest / LEAST)

    def place(value: float) -> float:
        return 100.0 * min(1.0, max(0.0, math.log(max(value, LEAST) / LEAST) / whole))

    return (100.0 if chi_square is None else place(chi_square)), place(1.0)
