"""Averaging over a cycle: the effect of damping and stiffness on amplitude and frequency, eqs. (3)-(5)."""

from math import gamma, pi, sqrt

import numpy as np

from identify.arrays import Array
from identify.compilation import compiled


def envelope_factors(angular_frequency: float, max_order: int) -> Array:
    """Return c_i / mu_i for i = 0..max_order, shape (max_order + 1,), from eq. (5).

    c_i = mu_i w0^(i-1) Gamma(i/2 + 1) / (sqrt(pi) Gamma(i/2 + 3/2)); the envelope obeys k' = -sum c_i k^i.
    """
    orders = range(max_order + 1)
    shape = [gamma(i / 2 + 1) / (sqrt(pi) * gamma(i / 2 + 1.5)) for i in orders]
    return np.array([angular_frequency ** (i - 1) * shape[i] for i in orders])


def backbone_factors(orders: tuple[int, ...]) -> Array:
    """Return the factors b_i of the odd stiffness orders in w^2 = k_1 + sum b_i k_i A^(i-1), shape (orders,).

    b_i = 2 Gamma(i/2 + 1) / (sqrt(pi) Gamma(i/2 + 3/2)): 1, 3/4 and 5/8 for the orders 1, 3 and 5, from
    the second of eqs. (3).
    """
    return np.array([2 * gamma(i / 2 + 1) / (sqrt(pi) * gamma(i / 2 + 1.5)) for i in orders])


@compiled()
def integrate_envelope(start: float, coefficients: Array, step: float, count: int) -> Array:
    """Return k at 0, step, ..., (count-1) step from k' = -sum c_i k^i with k(0) = start, shape (count,).

    Fourth-order Runge-Kutta; the envelope is held at zero once it has got there.
    """
    envelope = np.empty(count)
    k = start
    for i in range(count):
        envelope[i] = k
        slope, total = 0.0, 0.0
        for share, weight in ((0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)):
            at = k + share * step * slope
            loss = 0.0
            for c in coefficients[::-1]:
                loss = loss * at + c
            slope = -loss
            total += weight * slope
        k += step * total / 6
        if k < 0.0 or k > 10.0 * start:
            k = min(max(k, 0.0), 10.0 * start)
    return envelope
