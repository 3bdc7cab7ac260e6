"""The surface over displacement and velocity, and its sections where one of the two is zero."""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, frozen

BINS = 25
"""Of a section."""


@dataclass(frozen=True, eq=False)
class Section:
    """A cut of the surface, shape (n,) each.

    `position` (m or m/s), the measured force per unit mass with its standard error, and the fit.
    """

    position: Array
    force: Array
    std: Array
    fit: Array


@dataclass(frozen=True, eq=False)
class Polynomial:
    """The restoring force as a sum of terms: mu_i |v|^i sgn(v), chi_j u^j and a constant (eq. 15)."""

    damping: Array
    stiffness: dict[int, float]
    offset: float

    def elastic(self, displacement: Array) -> Array:
        """Return the part that displacement makes, with the constant, any shape."""
        return self.offset + sum((chi * displacement**j for j, chi in self.stiffness.items()), np.zeros(1))

    def dissipative(self, velocity: Array) -> Array:
        """Return the part that velocity makes, any shape."""
        speed = np.abs(velocity)
        loss = np.polynomial.polynomial.polyval(speed, self.damping)
        return np.asarray(np.sign(velocity) * loss)

    def __call__(self, displacement: Array, velocity: Array) -> Array:
        """Return the force per unit mass."""
        return self.elastic(displacement) + self.dissipative(velocity)


def sections_of(
    polynomial: Polynomial, displacement: Array, velocity: Array, force: Array
) -> tuple[Section, Section]:
    """Return the sections at v = 0 and at u = 0 of the measured points (n,).

    Points within a tenth of the largest velocity (displacement) of the cut are carried onto it along the fitted surface and
    averaged in bins; the sign of a velocity of zero counts as none, so the first section is elastic.
    """
    residual = force - polynomial(displacement, velocity)
    near_v = np.abs(velocity) < 0.1 * np.max(np.abs(velocity))
    near_u = np.abs(displacement) < 0.1 * np.max(np.abs(displacement))
    elastic = polynomial.elastic(displacement)
    dissipative = polynomial.dissipative(velocity) + polynomial.offset
    at_rest = _binned(displacement[near_v], (residual + elastic)[near_v])
    at_zero = _binned(velocity[near_u], (residual + dissipative)[near_u])
    return (
        Section(*map(frozen, (*at_rest, polynomial.elastic(at_rest[0])))),
        Section(*map(frozen, (*at_zero, polynomial.dissipative(at_zero[0]) + polynomial.offset))),
    )


def _binned(position: Array, force: Array) -> tuple[Array, Array, Array]:
    if len(position) < 2:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    edges = np.linspace(np.min(position), np.max(position) * (1 + 1e-12) + 1e-300, BINS + 1)
    cell = np.clip(np.searchsorted(edges, position, side="right") - 1, 0, BINS - 1)
    count = np.bincount(cell, minlength=BINS)
    full = count > 0
    mean = np.bincount(cell, force, BINS)[full] / count[full]
    centre = np.bincount(cell, position, BINS)[full] / count[full]
    slope = np.polyfit(position, force, 1)[0] if len(position) > 2 else 0.0
    flat = force - slope * position
    spread = np.sqrt(
        np.maximum(
            np.bincount(cell, flat**2, BINS)[full] / count[full]
            - (np.bincount(cell, flat, BINS)[full] / count[full]) ** 2,
            0.0,
        )
    )
    typical = float(np.sqrt(np.mean(spread**2))) or float(np.std(flat))
    return (
        centre,
        mean,
        np.where(count[full] > 4, np.maximum(spread, 0.3 * typical), typical) / np.sqrt(count[full]),
    )
