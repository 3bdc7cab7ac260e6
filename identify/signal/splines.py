"""B-splines by the recursion of de Boor and Cox, without the tenth of a second of loading `scipy.interpolate`."""

import numpy as np
from numpy.typing import NDArray

from identify.arrays import Array

DEGREE = 3
"""Degree of the splines: what twice-integrated noise asks for, and little freedom at the ends."""


def clamped_knots(low: float, high: float, spans: int) -> Array:
    """Return the knots of `spans` even spans, repeated at the ends, so that splines end there: (spans + 7,)."""
    return np.concatenate([[low] * DEGREE, np.linspace(low, high, spans + 1), [high] * DEGREE])


def basis(x: Array, knots: Array, degree: int = DEGREE) -> tuple[NDArray[np.int_], Array]:
    """Return the first spline over each point (n,) between the first and the last knot, and the values (n, degree + 1).

    The others over a point follow its first; their sum is one.
    """
    span = np.clip(np.searchsorted(knots, x, "right") - 1, degree, len(knots) - degree - 2)
    values = np.ones((len(x), 1))
    for d in range(1, degree + 1):
        above = knots[span[:, None] + np.arange(1, d + 1)] - x[:, None]
        below = x[:, None] - knots[span[:, None] + np.arange(1 - d, 1)]
        share = values / (above + below)
        values = np.pad(above * share, ((0, 0), (0, 1)))
        values[:, 1:] += below * share
    return span - degree, values


def spline_and_derivatives(x: Array, knots: Array, weights: Array, count: int) -> list[Array]:
    """Return the sum of splines times `weights` at points (n,), and its first `count` derivatives, (n,) each."""
    found = []
    for degree in range(DEGREE, DEGREE - count - 1, -1):
        first, values = basis(x, knots, degree)
        found.append(np.sum(values * weights[first[:, None] + np.arange(degree + 1)], axis=1))
        weights = degree * np.diff(weights) / (knots[degree + 1 : -1] - knots[1 : -degree - 1])
        knots = knots[1:-1]
    return found
