"""A slow fault: does the zero of the acceleration move?

The motion itself says where the acceleration's zero is: over a cycle it must add up to the change of velocity, whatever
the forces are. A zero that moves is the sensor's. (Of the displacement's zero nothing of the kind is known: a
slow motion of the mass would look the same.)
"""

from dataclasses import dataclass

import numpy as np

from identify.comparison.multiple_shooting import MultipleShooting
from identify.comparison.residual_force import estimate_extra_force, phase_bins

_ORDERS = (1, 2, 3)
_BINS = 7


@dataclass(frozen=True)
class ZeroDrift:
    """The drift of the acceleration's zero: its range (m/s^2), and the same in standard errors."""

    size: float
    significance: float


def find_zero_drift(shooting: MultipleShooting) -> ZeroDrift | None:
    """Return the slow change of the acceleration's zero beside any force of u and v; None without a second channel."""
    window = shooting.window
    if not window.paired:
        return None
    clock = np.linspace(-1.0, 1.0, len(window))
    shapes = np.column_stack([np.polynomial.legendre.legval(clock, np.eye(n + 1)[n]) for n in _ORDERS])
    change = {c: np.zeros(shapes.shape) for c in window.channels}
    change["acceleration"] = shapes * window.sigma["acceleration"]
    patterns = phase_bins(shooting, _BINS)[-1]
    found = estimate_extra_force(shooting, patterns, shooting.whitened(change))
    count = patterns.shape[1]
    size, covariance = found.size[count:], found.covariance[count:, count:]
    score = float(size @ np.linalg.solve(covariance, size)) / max(1.0, found.chi_square_after)
    # Wilson and Hilferty (1931): chi-square of three degrees of freedom as a normal score.
    normal = ((score / 3.0) ** (1.0 / 3.0) - (1.0 - 2.0 / 27.0)) / np.sqrt(2.0 / 27.0)
    return ZeroDrift(float(np.ptp(shapes @ size)) * window.sigma["acceleration"], float(normal))
