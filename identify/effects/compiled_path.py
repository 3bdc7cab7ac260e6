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


@compiled(nogil=True, error_model="numpy", forceinline=True)
def _between(x, whole, u, v, at):  # type: ignore[no-untyped-def]
    """Return displacement and velocity at a share x of the `whole` time from sample `at` to the next.

    The velocity is straight, the displacement its integral; what that misses of the next reading is taken out in proportion.
    """
    dv = v[at + 1] - v[at]
    missed = u[at + 1] - u[at] - whole * (v[at] + 0.5 * dv)
    return u[at] + x * (whole * (v[at] + 0.5 * x * dv) + missed), v[at] + x * dv


@compiled(nogil=True, error_model="numpy")
def states_along(address, time, u, v, p, start, steps):  # type: ignore[no-untyped-def]
    """Return the internal states, (n, 2), driven along a motion from `start`.

    By the classical Runge-Kutta method, in `steps` steps between samples.
    """
    out = np.empty((u.shape[0], 2))
    z = (start[0], start[1])
    for i in range(u.shape[0] - 1):
        out[i, 0], out[i, 1] = z
        whole = time[i + 1] - time[i]
        h = whole / steps
        for k in range(steps):
            t = time[i] + k * h
            u0, v0 = _between(k / steps, whole, u, v, i)
            um, vm = _between((k + 0.5) / steps, whole, u, v, i)
            u1, v1 = _between((k + 1.0) / steps, whole, u, v, i)
            a0, a1 = call_rates(address, t, u0, v0, z, p)
            b0, b1 = call_rates(address, t + 0.5 * h, um, vm, (z[0] + 0.5 * h * a0, z[1] + 0.5 * h * a1), p)
            c0, c1 = call_rates(address, t + 0.5 * h, um, vm, (z[0] + 0.5 * h * b0, z[1] + 0.5 * h * b1), p)
            d0, d1 = call_rates(address, t + h, u1, v1, (z[0] + h * c0, z[1] + h * c1), p)
            z = (z[0] + h / 6.0 * (a0 + 2.0 * (b0 + c0) + d0), z[1] + h / 6.0 * (a1 + 2.0 * (b1 + c1) + d1))
    out[-1, 0], out[-1, 1] = z
    return out
