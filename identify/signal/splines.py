"""Cubic B-splines with even knots, without the tenth of a second of loading `scipy.interpolate`."""

import numpy as np
from numpy.typing import NDArray

from identify.arrays import Array

DEGREE = 3
"""Degree of the splines: what twice-integrated noise asks for, and little freedom at the ends."""

_PIECES = (
    np.array([[1.0, 4.0, 1.0, 0.0], [-3.0, 0.0, 3.0, 0.0], [3.0, -6.0, 3.0, 0.0], [-1.0, 3.0, -3.0, 1.0]])
    / 6.0
)
"""The four splines over a span, each a cubic: the coefficients of each power of the share of the span."""


def basis(
    x: Array, low: float, high: float, spans: int, derivative: int = 0
) -> tuple[NDArray[np.int_], Array]:
    """Return the first of the splines over each point (n,) of `low` to `high`, and the values of four, (n, 4).

    Of the spans + 3 splines the others over a point follow its first; their sum is one. Or a `derivative` of them.
    """
    step = (high - low) / spans
    first = np.clip((x - low) / step, 0, spans - 1).astype(int)
    pieces = np.polynomial.polynomial.polyder(_PIECES, derivative)
    values = np.polynomial.polynomial.polyval((x - low) / step - first, pieces)
    return first, np.asarray(values.T / step**derivative)
