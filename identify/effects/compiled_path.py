"""A compiled effect along a given motion: its value at every sample, and its internal states from sample to sample."""

import numpy as np

from identify.compilation import compiled
from identify.effects.compiled import call_force, call_rates


@compiled(nogil=True, error_model="numpy")
def values_along(address, time, u, v, states, p):  # type: ignore[no-untyped-def]
    """Return a force or a level of friction, (n,), along a motion `time`, `u`, `v` (n,) with `states` (n, 2)."""
    out = np.empty(u.shape[0])
    for i in range(u.shape[0]):
        out[i] = call_force(address, time[i], u[i], v[i], (states[i, 0], states[i, 1]), p)
    return out


@compiled(nogil=True, error_model="numpy")
def states_along(address, time, u, v, p, start, steps):  # type: ignore[no-untyped-def]
    """Return the internal states, (n, 2), driven along a motion from `start`.

    Between samples the motion is taken as straight, and the states follow it in `steps` steps of the midpoint rule.
    """
    out = np.empty((u.shape[0], 2))
    z = (start[0], start[1])
    for i in range(u.shape[0]):
        out[i, 0], out[i, 1] = z
        if i + 1 == u.shape[0]:
            break
        h = (time[i + 1] - time[i]) / steps
        du, dv = u[i + 1] - u[i], v[i + 1] - v[i]
        for k in range(steps):
            early, middle = k / steps, (k + 0.5) / steps
            t = time[i] + k * h
            r0, r1 = call_rates(address, t, u[i] + early * du, v[i] + early * dv, z, p)
            half = (z[0] + 0.5 * h * r0, z[1] + 0.5 * h * r1)
            r0, r1 = call_rates(address, t + 0.5 * h, u[i] + middle * du, v[i] + middle * dv, half, p)
            z = (z[0] + h * r0, z[1] + h * r1)
    return out


@compiled(nogil=True, error_model="numpy")
def states_along_smooth(address, time, u, v, p, start):  # type: ignore[no-untyped-def]
    """Return the internal states at every second sample of a smooth motion, (n, 2) for `u`, `v` of 2 n - 1 samples.

    The samples between are the midpoints of the classical Runge-Kutta method.
    """
    n = (u.shape[0] - 1) // 2
    out = np.empty((n + 1, 2))
    z = (start[0], start[1])
    for i in range(n):
        out[i, 0], out[i, 1] = z
        at = 2 * i
        h = time[at + 2] - time[at]
        a0, a1 = call_rates(address, time[at], u[at], v[at], z, p)
        y = (z[0] + 0.5 * h * a0, z[1] + 0.5 * h * a1)
        b0, b1 = call_rates(address, time[at + 1], u[at + 1], v[at + 1], y, p)
        y = (z[0] + 0.5 * h * b0, z[1] + 0.5 * h * b1)
        c0, c1 = call_rates(address, time[at + 1], u[at + 1], v[at + 1], y, p)
        y = (z[0] + h * c0, z[1] + h * c1)
        d0, d1 = call_rates(address, time[at + 2], u[at + 2], v[at + 2], y, p)
        z = (z[0] + h / 6.0 * (a0 + 2.0 * (b0 + c0) + d0), z[1] + h / 6.0 * (a1 + 2.0 * (b1 + c1) + d1))
    out[n, 0], out[n, 1] = z
    return out
