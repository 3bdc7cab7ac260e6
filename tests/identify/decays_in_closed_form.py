"""Motions in closed form: the truth that the kinematic tests look for."""

import math

import numpy as np

from identify.arrays import Array


def exponential(
    time: Array, frequency: float, amplitude: float = 0.02, decay: float = 0.14
) -> tuple[Array, Array, Array]:
    """u, v, a of A e^(-d t) cos(w t): a viscous decay in mid-motion."""
    s = complex(-decay, 2.0 * math.pi * frequency)
    z = amplitude * np.exp(s * np.asarray(time))
    return z.real, (s * z).real, (s * s * z).real


def coulomb(
    time: Array, frequency: float, amplitude: float = 0.02, offset: float = 4e-4
) -> tuple[Array, Array, Array]:
    """u, v, a of a mass let go at t = 0 under dry friction alone: half-cosines about +-offset, then stuck.

    `offset` is mu_0 / w^2. Before t = 0 the mass is held at `amplitude`.
    """
    omega = 2.0 * math.pi * frequency
    t = np.asarray(time, dtype=float)
    u = np.full(t.shape, amplitude)
    v, a = np.zeros(t.shape), np.zeros(t.shape)
    start, half = amplitude, 0
    while abs(start) > offset:
        side = math.copysign(1.0, start)
        centre = side * offset
        here = (t >= half * math.pi / omega) & (t < (half + 1) * math.pi / omega)
        phase = omega * t[here] - half * math.pi
        u[here] = centre + (start - centre) * np.cos(phase)
        v[here] = -omega * (start - centre) * np.sin(phase)
        a[here] = -(omega**2) * (start - centre) * np.cos(phase)
        start = 2.0 * centre - start
        half += 1
    u[t >= half * math.pi / omega] = start
    return u, v, a
