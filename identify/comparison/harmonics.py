"""Harmonics: the force that the model lacks, at multiples of the motion's own frequency."""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, frozen
from identify.comparison.multiple_shooting import MultipleShooting
from identify.comparison.residual_force import estimate_extra_force

HIGHEST = 5


@dataclass(frozen=True, eq=False)
class Harmonics:
    """Residual force per unit mass (m/s^2) at 0, 1, 2 ... times the frequency, as if constant over the record.

    With u = A cos(theta) the force is the sum over n of amplitude cos(n theta + phase), each of shape (orders,); at phase 0
    it is with the displacement, at a quarter with the velocity. `significance` is in standard errors.
    """

    order: Array
    amplitude: Array
    phase: Array
    significance: Array


def compare_harmonics(shooting: MultipleShooting) -> Harmonics:
    """Return the harmonics, up to the fifth where the rate allows, of the force that the tracked model lacks."""
    angle = np.arctan2(-shooting.velocity / shooting.frequency, shooting.displacement)
    top = int(min(HIGHEST, max(1, np.floor(0.4 * shooting.window.rate * 2.0 * np.pi / shooting.frequency))))
    orders = np.arange(top + 1)
    patterns = np.column_stack([np.cos(n * angle) for n in orders] + [-np.sin(n * angle) for n in orders[1:]])
    found = estimate_extra_force(shooting, patterns)
    significance = np.empty(top + 1)
    for n in orders:
        places = [n] if n == 0 else [n, top + n]
        size = found.size[places]
        significance[n] = np.sqrt(size @ np.linalg.solve(found.covariance[np.ix_(places, places)], size))
    cosine, sine = found.size[: top + 1], np.concatenate([[0.0], found.size[top + 1 :]])
    return Harmonics(
        frozen(orders.astype(float)),
        frozen(np.hypot(cosine, sine)),
        frozen(np.arctan2(sine, cosine)),
        frozen(significance),
    )
