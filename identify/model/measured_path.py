"""Along the measured motion: the forces and internal states of a fitted effect where the mass has been."""

import numpy as np
from numba import njit

from identify.arrays import Array
from identify.effects.compiled import (
    PARAMETERS,
    address_of_force,
    address_of_rates,
    call_force,
    call_rates,
)
from identify.model.model import Model, Term

_STEPS = 8
_DRIVE_STEPS = 8


def model_force(model: Model, values: dict[str, float], time: Array, u: Array, v: Array) -> Array:
    """Return the force per unit mass (m/s^2) that a fitted model gives at a motion, shape (n,).

    `values` holds the parameters by "effect.parameter"; `time` (n,) is in s since the release, `u` and `v` (n,) are
    displacement from the spring's zero and velocity.
    """
    total = np.zeros(len(u))
    for term in model.terms:
        if term.effect.kind == "physics":
            total += effect_force(term, values, time, u, v)
    return total


def effect_force(term: Term, values: dict[str, float], time: Array, u: Array, v: Array) -> Array:
    """Return the force per unit mass of one fitted effect, shape (n,)."""
    effect = term.effect
    if effect.name == "linear_stiffness":
        return values["linear_stiffness.k"] * u
    if effect.name == "viscous_damping":
        return values["viscous_damping.mu_1"] * v
    if effect.name == "coulomb_friction":
        return values["coulomb_friction.mu_0"] * np.sign(v)
    states = np.zeros((len(u), 2)) if effect.rates is None else states_along(term, values, time, u, v)
    force: Array = _evaluate(
        address_of_force(effect.force),
        address_of_force(effect.friction),
        time,
        u,
        v,
        states,
        _parameters(term, values),
    )
    return force


def states_along(term: Term, values: dict[str, float], time: Array, u: Array, v: Array) -> Array:
    """Return the internal states (n, 2) of a fitted effect with memory, driven along a motion."""
    start = [values.get(f"{term.effect.name}.state{j}", 0.0) for j in range(2)]
    driven: Array = _drive(
        address_of_rates(term.effect.rates), time, u, v, _parameters(term, values), *start, _STEPS
    )
    return driven


def _parameters(term: Term, values: dict[str, float]) -> tuple[float, ...]:
    effect = term.effect
    p = [
        float(term.held[q.name]) if q.name in term.held else float(values[f"{effect.name}.{q.name}"])
        for q in effect.parameters
    ]
    p += [float(values[name]) for name in effect.shared_parameters]
    return tuple(p + [0.0] * (PARAMETERS - len(p)))


@njit(cache=True, nogil=True, error_model="numpy")
def _evaluate(force, friction, time, u, v, states, p):  # type: ignore[no-untyped-def]
    out = np.zeros(u.shape[0])
    for i in range(u.shape[0]):
        z = (states[i, 0], states[i, 1])
        if force != 0:
            out[i] += call_force(force, time[i], u[i], v[i], z, p)
        if friction != 0:
            out[i] += call_force(friction, time[i], u[i], v[i], z, p) * np.sign(v[i])
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _drive(address, time, u, v, p, z0, z1, steps):  # type: ignore[no-untyped-def]
    out = np.empty((u.shape[0], 2))
    z = (z0, z1)
    for i in range(u.shape[0]):
        out[i, 0], out[i, 1] = z
        if i + 1 == u.shape[0]:
            break
        h = (time[i + 1] - time[i]) / steps
        du, dv = u[i + 1] - u[i], v[i + 1] - v[i]
        for k in range(steps):
            x = k / steps
            r0, r1 = call_rates(address, time[i] + k * h, u[i] + x * du, v[i] + x * dv, z, p)
            half = (z[0] + 0.5 * h * r0, z[1] + 0.5 * h * r1)
            x = (k + 0.5) / steps
            r0, r1 = call_rates(address, time[i] + (k + 0.5) * h, u[i] + x * du, v[i] + x * dv, half, p)
            z = (z[0] + h * r0, z[1] + h * r1)
    return out


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
    term: Term, inner: dict[str, float], time: Array, u: Array, v: Array, shared: dict[str, float]
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
    for offset, name in enumerate(effect.shared_parameters):
        p[len(effect.parameters) + offset] = shared[name]
    start = effect.equilibrium_state(float(u[0]), p) if effect.equilibrium_state is not None else (0.0, 0.0)
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
