"""The surface over displacement and velocity, and its sections where one of the two is zero."""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, frozen


@dataclass(frozen=True, eq=False)
class Section:
    """A cut of the surface, shape (n,) each.

    `position` (m or m/s) in ascending order, the measured force per unit mass, and the fit.
    """

    position: Array
    force: Array
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

    Points within a tenth of the largest velocity (displacement) of the cut are carried onto it along the fitted surface;
    the sign of a velocity of zero counts as none, so the first section is elastic.
    """
    residual = force - polynomial(displacement, velocity)
    elastic = polynomial.elastic(displacement)
    dissipative = polynomial.dissipative(velocity) + polynomial.offset
    return _section(displacement, velocity, elastic, residual), _section(
        velocity, displacement, dissipative, residual
    )


def _section(along: Array, across: Array, fit: Array, residual: Array) -> Section:
    near = np.flatnonzero(np.abs(across) < 0.1 * np.max(np.abs(across)))
    near = near[np.argsort(along[near])]
    return Section(frozen(along[near]), frozen((fit + residual)[near]), frozen(fit[near]))
