"""Equation error: forces regressed on the measured motion. Quick, and good enough to start a fit from.

At every sample the restoring force, less any recorded one, is the sum of the forces at the measured displacement and
velocity. Internal states are driven along the measured motion. Samples of small speed are left out: the sign of a noisy
velocity is noise.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from identify.arrays import Array, Mask
from identify.effects.compiled import (
    PARAMETERS,
    address_of_force,
    address_of_rates,
    call_force,
    call_rates,
)
from identify.model import Term
from identify.motion import Motion

_DRIVE_STEPS = 8


@dataclass(frozen=True, eq=False)
class Regression:
    """Linear strengths by effect name, in the order of the terms, and what they leave.

    `strengths` (terms,), `constant` (m/s^2), `residual` (n,) of the restoring force at every sample, `rss` its
    sum of squares over the samples used, `count` how many they are.
    """

    strengths: Array
    constant: float
    residual: Array
    rss: float
    count: int


@njit(cache=True, nogil=True, error_model="numpy")
def _forces_along(address_force, address_friction, address_rates, time, u, v, p, start, steps):  # type: ignore[no-untyped-def]
    n = u.shape[0]
    out = np.zeros(n)
    z = (start[0], start[1])
    for i in range(n):
        if address_force != 0:
            out[i] += call_force(address_force, time[i], u[i], v[i], z, p)
        if address_friction != 0:
            out[i] += call_force(address_friction, time[i], u[i], v[i], z, p) * np.sign(v[i])
        if address_rates != 0 and i + 1 < n:
            h = (time[i + 1] - time[i]) / steps
            for k in range(steps):
                x = (k + 0.5) / steps
                mid_u = u[i] + x * (u[i + 1] - u[i])
                mid_v = v[i] + x * (v[i + 1] - v[i])
                early_u = u[i] + k / steps * (u[i + 1] - u[i])
                early_v = v[i] + k / steps * (v[i + 1] - v[i])
                t = time[i] + k * h
                r0, r1 = call_rates(address_rates, t, early_u, early_v, z, p)
                middle = (z[0] + 0.5 * h * r0, z[1] + 0.5 * h * r1)
                r0, r1 = call_rates(address_rates, t + 0.5 * h, mid_u, mid_v, middle, p)
                z = (z[0] + h * r0, z[1] + h * r1)
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def states_after(address_rates, time, u, v, p, start, steps):  # type: ignore[no-untyped-def]
    """Return the two internal states at the end of a motion (time, u, v), from `start` at its beginning."""
    z = (start[0], start[1])
    for i in range(u.shape[0] - 1):
        h = (time[i + 1] - time[i]) / steps
        for k in range(steps):
            early, middle = k / steps, (k + 0.5) / steps
            t = time[i] + k * h
            u0 = u[i] + early * (u[i + 1] - u[i])
            v0 = v[i] + early * (v[i + 1] - v[i])
            r0, r1 = call_rates(address_rates, t, u0, v0, z, p)
            half = (z[0] + 0.5 * h * r0, z[1] + 0.5 * h * r1)
            u1 = u[i] + middle * (u[i + 1] - u[i])
            v1 = v[i] + middle * (v[i + 1] - v[i])
            r0, r1 = call_rates(address_rates, t + 0.5 * h, u1, v1, half, p)
            z = (z[0] + h * r0, z[1] + h * r1)
    return z


def force_along(
    term: Term, inner: dict[str, float], time: Array, u: Array, v: Array, borrowed: dict[str, float]
) -> Array:
    """Return the force per unit mass and unit strength of an effect along a motion, shape (n,)."""
    effect = term.effect
    if effect.name == "linear_stiffness":
        return u
    if effect.name == "viscous_damping":
        return v
    if effect.name == "coulomb_friction":
        return np.sign(v)
    p = np.zeros(PARAMETERS)
    p[0] = 1.0
    for j, parameter in enumerate(effect.parameters[1:], start=1):
        held = term.held.get(parameter.name)
        p[j] = float(held) if held is not None else inner[parameter.name]
    for offset, name in enumerate(effect.borrows):
        p[len(effect.parameters) + offset] = borrowed[name]
    start = effect.rest(float(u[0]), p) if effect.rest is not None else (0.0, 0.0)
    result: Array = _forces_along(
        address_of_force(effect.force),
        address_of_force(effect.friction),
        address_of_rates(effect.rates),
        time,
        u,
        v,
        tuple(p),
        start,
        _DRIVE_STEPS if effect.rates is not None else 1,
    )
    return result


def moving(motion: Motion, *, sigmas: float = 3.0) -> Mask:
    """Return where the velocity is known to differ from zero and its sign does not change nearby, shape (n,)."""
    noise = motion.noise_velocity or 0.0
    speed = np.abs(motion.velocity)
    fast = speed > max(sigmas * noise, 0.02 * float(speed.max(initial=0.0)))
    steady = fast.copy()
    steady[1:] &= fast[:-1]
    steady[:-1] &= fast[1:]
    return motion.valid & steady


def regress(restoring: Array, columns: Array, used: Mask, noise: float = 1.0) -> Regression:
    """Least squares of the measured restoring force per unit mass (n,) on force columns (n, terms) and a constant."""
    design = np.column_stack([columns, np.ones(len(columns))])
    if not np.isfinite(design[used]).all():  # a state that ran away
        return Regression(np.zeros(columns.shape[1]), 0.0, restoring, np.inf, int(used.sum()))
    size = np.linalg.norm(design[used], axis=0)
    size[size == 0.0] = 1.0
    solution = np.linalg.lstsq(design[used] / size, restoring[used], rcond=1e-12)[0] / size
    residual = restoring - design @ solution
    rss = float(np.sum(residual[used] ** 2)) / noise**2
    return Regression(solution[:-1], float(solution[-1]), residual, rss, int(used.sum()))
