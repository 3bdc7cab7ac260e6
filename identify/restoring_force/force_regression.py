"""The regression of the restoring force: eq. (17) under the windows, for every damping order."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from identify.algebra import whiten
from identify.arrays import Array
from identify.free_decay import FreeDecay
from identify.restoring_force.force_window import ForceWindow
from identify.restoring_force.velocity_sign import (
    Direction,
    band_of_reversals,
    direction_of,
    refine_reversals,
    rows_of_sign,
)
from identify.signal.covariance import misfit_covariance
from identify.signal.weak_form import (
    LeastSquares,
    Windows,
    band_of,
    factor_of,
    rows_of,
    solve,
)


@dataclass(frozen=True, eq=False)
class Polynomial:
    """The restoring force as a sum of terms: mu_i |v|^i sgn(v), chi_j u^j and a constant (eq. 15)."""

    damping: Array
    stiffness: dict[int, float]
    offset: float

    def elastic(self, displacement: Array) -> Array:
        """Return the part that displacement makes, with the constant, any shape."""
        return self.offset + sum((chi * displacement**j for j, chi in self.stiffness.items()), np.zeros(1))

    def rest(self, displacement: Array) -> float:
        """Return the displacement at which the elastic part pulls nowhere, by its mean slope along some, (n,).

        By the slope at 0 a spring that hardens strongly would be missed by more each time. 0 where the slope is none.
        """
        slope = np.mean(sum(j * chi * displacement ** (j - 1) for j, chi in self.stiffness.items()))
        return -self.offset / float(slope) if slope > 0.0 else 0.0

    def dissipative(self, velocity: Array) -> Array:
        """Return the part that velocity makes, any shape."""
        speed = np.abs(velocity)
        loss = np.polynomial.polynomial.polyval(speed, self.damping)
        return np.asarray(np.sign(velocity) * loss)

    def __call__(self, displacement: Array, velocity: Array) -> Array:
        """Return the force per unit mass."""
        return self.elastic(displacement) + self.dissipative(velocity)


@dataclass(frozen=True, eq=False)
class ForceFit:
    """Eq. (17) solved for one damping order; `clear` is how many standard errors its highest
    damping stands from zero."""

    order: int
    solution: LeastSquares
    clear: float
    covariance: Array
    polynomial: Polynomial
    force_gain: float

    @property
    def std(self) -> Array:
        """Standard errors of damping, stiffness, offset and, where it was unknown, 1/m, in this order."""
        return np.sqrt(np.diag(self.covariance))


def fit_orders(
    window: ForceWindow, windows: Windows, max_order: int, stiffness_orders: tuple[int, ...], decay: FreeDecay
) -> list[ForceFit]:
    """Solve eq. (17) for every damping order, with one covariance of the rows.

    A first solution, of second order at most, says how friction bends the velocity at a reversal, and where the
    resonance lies.
    """
    motion, w = window.motion, window.angular_frequency
    u, v = window.cut(motion.displacement), window.cut(motion.velocity)
    force = None if window.force is None else window.cut(window.force)
    unknown_mass = force is not None and decay.mass is None
    others = [u**j for j in stiffness_orders] + [np.ones_like(u)]
    if force is not None and unknown_mass:
        others.append(-force)
    powers = [np.abs(v) ** i * np.sign(v) for i in range(2, max(max_order, 1) + 1)]
    pull = np.zeros_like(u) if force is None or unknown_mass else force
    sums = rows_of(windows, windows.derivative(0), np.stack([*powers, *others, pull]))
    # phi vanishes at its ends, so derivatives may pass from the motion to the window
    centred = (u - np.mean(u))[None]
    viscous = -rows_of(windows, windows.derivative(1), centred)
    sums[:, -1:] -= rows_of(windows, windows.derivative(2), centred)

    def rows(direction: Direction) -> Array:
        return np.column_stack([rows_of_sign(windows, direction), viscous, sums])

    direction = direction_of(v)
    factor = factor_of(_covariance(window, windows, 0.0, w**2))
    order = min(max(max_order, 1), 2)
    first = _solved(rows(direction), factor, order, len(others)).values
    mu_0, mu_1, drag = first[0], first[1], first[2] if order == 2 else 0.0
    k_1 = first[order + 1] if 1 in stiffness_orders else w**2

    direction = refine_reversals(v, direction, max(mu_0, 0.0), drag, motion.rate, w, window.blur)
    band = _covariance(window, windows, mu_1, k_1)
    band += band_of_reversals(windows, len(band), direction, 2 * mu_0, v, motion.noise_velocity)
    found = rows(direction)
    factor = factor_of(band)
    solutions = [_solved(found, factor, order, len(others)) for order in range(max_order + 1)]
    # all reversals too late by one time: small, but no number of cycles averages it out
    late = Direction(
        direction.before, np.where(direction.at < 1, direction.at - window.late * motion.rate, 1.0)
    )
    common = whiten(factor, mu_0 * (rows_of_sign(windows, late) - found[:, 0])[:, None])
    fits = [_fit(solution, common, stiffness_orders, unknown_mass) for solution in solutions]
    return [_without_viscous(*fits[:2]), *fits[1:]] if max_order else fits


def _without_viscous(dry: ForceFit, usual: ForceFit) -> ForceFit:
    """Give dry friction alone the errors that it has beside viscous damping, and what that would change."""
    kept = [i for i in range(len(usual.covariance)) if i != 1]
    changed = usual.solution.values[kept] - dry.solution.values
    return replace(dry, covariance=usual.covariance[np.ix_(kept, kept)] + np.outer(changed, changed))


def _solved(rows: Array, factor: Array, order: int, others: int) -> LeastSquares:
    kept = [*range(order + 1), *range(rows.shape[1] - 1 - others, rows.shape[1])]
    white = whiten(factor, rows[:, kept])
    return solve(white[:, :-1], white[:, -1])


def _fit(
    solution: LeastSquares, common: Array, stiffness_orders: tuple[int, ...], unknown_mass: bool
) -> ForceFit:
    order = len(solution.values) - len(stiffness_orders) - 2 - unknown_mass
    residual = solution.white.reshape(-1, 2).T.ravel()
    gain = solution.gain.reshape(len(solution.gain), -1, 2).swapaxes(1, 2).reshape(len(solution.gain), -1)
    shift = solution.gain @ common
    covariance = solution.covariance + shift @ shift.T
    covariance += misfit_covariance(residual, gain, len(residual), len(gain))
    clear = abs(float(solution.values[order])) / float(np.sqrt(covariance[order, order]))
    stiffness = {
        j: float(chi) for j, chi in zip(stiffness_orders, solution.values[order + 1 :], strict=False)
    }
    offset = float(solution.values[order + 1 + len(stiffness_orders)])
    force_gain = float(solution.values[-1]) if unknown_mass else 1.0
    return ForceFit(
        order,
        solution,
        clear,
        covariance,
        Polynomial(solution.values[: order + 1], stiffness, offset),
        force_gain,
    )


def _covariance(window: ForceWindow, windows: Windows, mu_1: float, k_1: float) -> Array:
    """Covariance of the rows: what the noise of the displacement does to both sides of the equation of motion."""
    kernel = windows.derivative(2) + k_1 * windows.derivative(0) - mu_1 * windows.derivative(1)
    w = window.angular_frequency
    band = band_of(windows, kernel, _above(window.noise, w))
    try:
        factor_of(band)
    except np.linalg.LinAlgError:
        # a steep spectrum reaches further than the band that is kept: take it as white, at its level at the resonance
        return float(window.noise(np.array([w]))[0]) * band_of(windows, kernel, np.ones_like)
    return band


def _above(spectrum: Callable[[Array], Array], w: float) -> Callable[[Array], Array]:
    """Hold a spectrum that rises towards zero frequency at its value at a third of the natural one."""
    return lambda at: spectrum(np.maximum(at, w / 3))
