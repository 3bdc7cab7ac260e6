"""The signature of an effect: what it does to the decay and to the frequency, at every amplitude.

Along a harmonic motion u = A cos(w t) a small force f changes the amplitude as A' = -c_eq A / 2 and the frequency by
dw2 = change of w^2, with (first-order averaging, Krylov and Bogoliubov 1937)
    c_eq = <f v> / <v^2>,    dw2 = <f u> / <u^2>.
A force that is even in the displacement moves the centre and adds even harmonics, by which w^2 changes in second order.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit

from identify.arrays import Array, frozen
from identify.effects.compiled import (
    PARAMETERS,
    address_of_force,
    address_of_rates,
    call_force,
    call_rates,
)
from identify.effects.effect import Effect

_POINTS = 512
_MOST_CYCLES = 400
_SETTLED = 1e-6


@dataclass(frozen=True, eq=False)
class Signature:
    """Equivalent viscous damping `damping` (1/s) and change of w^2 `stiffening` (1/s^2) at each `amplitude`, shape (n,).

    `settled` is False where the internal states did not become periodic.
    """

    amplitude: Array
    damping: Array
    stiffening: Array
    settled: bool


@njit(cache=True, nogil=True, error_model="numpy")
def _cycle(force, friction, rates, time, u, v, z0, z1, p, out):  # type: ignore[no-untyped-def]
    """Run the internal states once around (classical Runge-Kutta over two points), write the force at even points."""
    z = (z0, z1)
    n = (u.shape[0] - 1) // 2
    for i in range(n):
        at = 2 * i
        out[i] = 0.0
        if force != 0:
            out[i] += call_force(force, time[at], u[at], v[at], z, p)
        if friction != 0:
            out[i] += max(call_force(friction, time[at], u[at], v[at], z, p), 0.0) * np.sign(v[at])
        if rates != 0:
            h = time[at + 2] - time[at]
            a0, a1 = call_rates(rates, time[at], u[at], v[at], z, p)
            y = (z[0] + 0.5 * h * a0, z[1] + 0.5 * h * a1)
            b0, b1 = call_rates(rates, time[at + 1], u[at + 1], v[at + 1], y, p)
            y = (z[0] + 0.5 * h * b0, z[1] + 0.5 * h * b1)
            c0, c1 = call_rates(rates, time[at + 1], u[at + 1], v[at + 1], y, p)
            y = (z[0] + h * c0, z[1] + h * c1)
            d0, d1 = call_rates(rates, time[at + 2], u[at + 2], v[at + 2], y, p)
            z = (z[0] + h / 6.0 * (a0 + 2.0 * (b0 + c0) + d0), z[1] + h / 6.0 * (a1 + 2.0 * (b1 + c1) + d1))
    return z


def average(
    effect: Effect, parameters: dict[str, float], frequency: float, amplitudes: Array, *, time: float = 0.0
) -> Signature:
    """Return the signature of one effect at `amplitudes` (n,) of a motion of angular `frequency` (rad/s).

    `parameters` holds its parameters, and those it borrows by their full name. What depends on time is taken at
    `time` s after the release. Raises ValueError for a sensor's fault, which is no force, and names a parameter
    that is missing.
    """
    if effect.kind != "physics":
        raise ValueError(f"{effect.name} is a fault of a sensor: it has no force, and so no signature")
    p = _parameters(effect, parameters)
    if effect.name in _LINEAR:
        return _linear(effect.name, p[0], frequency, amplitudes)
    damping, stiffening = np.zeros(len(amplitudes)), np.zeros(len(amplitudes))
    settled = True
    for i, amplitude in enumerate(amplitudes):
        force, angle, calm = _around(effect, p, frequency, float(amplitude), time)
        settled &= calm
        u, v = amplitude * np.cos(angle), -amplitude * frequency * np.sin(angle)
        damping[i] = np.mean(force * v) / np.mean(v * v)
        stiffening[i] = np.mean(force * u) / np.mean(u * u)
        if effect.force is not None and effect.rates is None:
            stiffening[i] += _second_order(effect, p, frequency, float(amplitude), time)
    return Signature(frozen(amplitudes), frozen(damping), frozen(stiffening), settled)


_LINEAR = ("linear_stiffness", "viscous_damping", "coulomb_friction")


def _linear(name: str, strength: float, frequency: float, amplitudes: Array) -> Signature:
    """The three effects that the simulator has built in, in closed form."""
    none, all_ = np.zeros(len(amplitudes)), np.full(len(amplitudes), strength)
    if name == "linear_stiffness":
        return Signature(frozen(amplitudes), frozen(none), frozen(all_), True)
    if name == "viscous_damping":
        return Signature(frozen(amplitudes), frozen(all_), frozen(none), True)
    return Signature(
        frozen(amplitudes), frozen(4.0 * strength / (np.pi * frequency * amplitudes)), frozen(none), True
    )


def _parameters(effect: Effect, given: dict[str, float]) -> tuple[float, ...]:
    values = []
    for name in (*(q.name for q in effect.parameters), *effect.shared_parameters):
        if name not in given:
            raise ValueError(f"{effect.name} needs a value of {name}")
        values.append(float(given[name]))
    return tuple(values + [0.0] * (PARAMETERS - len(values)))


def _around(
    effect: Effect, p: tuple[float, ...], frequency: float, amplitude: float, time: float
) -> tuple[Array, Array, bool]:
    """Return the force (points,) once around, the phase of the points, and whether the internal states are periodic.

    The points lie between the reversals, never on them, so that the sign of the velocity is never in doubt. A
    periodic state is found by Newton's method on the map of one cycle, which serves contracting and lightly
    damped states alike.
    """
    angle = 2.0 * np.pi * (np.arange(2 * _POINTS + 1) + 1.0) / (2 * _POINTS)
    u, v = amplitude * np.cos(angle), -amplitude * frequency * np.sin(angle)
    clock = time + (np.zeros(len(angle)) if effect.rates is None else angle / frequency)
    addresses = (
        address_of_force(effect.force),
        address_of_force(effect.friction),
        address_of_rates(effect.rates),
    )
    force = np.empty(_POINTS)

    def turn(state: Array) -> Array:
        return np.array(_cycle(*addresses, clock, u, v, state[0], state[1], p, force))

    if effect.rates is None:
        turn(np.zeros(2))
        return force, angle[:-1:2], True
    start = (
        effect.equilibrium_state(amplitude, np.array(p))
        if effect.equilibrium_state is not None
        else (0.0, 0.0)
    )
    state = np.array(start, dtype=float)
    scale = np.array([amplitude, amplitude * frequency])
    settled = False
    for k in range(_MOST_CYCLES):
        after = turn(state)
        if np.max(np.abs(after - state) / scale) < _SETTLED:
            settled = True
            break
        state = after
        if k % 8 == 7:
            state = _closer(turn, state, scale, effect.states)
    turn(state)
    return force, angle[:-1:2], settled


def _closer(turn: Callable[[Array], Array], state: Array, scale: Array, states: int) -> Array:
    """One step of Newton's method towards a state that comes back to itself; the state itself where it does not help."""
    after = turn(state)
    slope = np.zeros((states, states))
    for j in range(states):
        moved = state.copy()
        moved[j] += 1e-4 * scale[j]
        slope[:, j] = (turn(moved) - after)[:states] / (1e-4 * scale[j])
    try:
        step = np.linalg.solve(np.eye(states) - slope, (after - state)[:states])
    except np.linalg.LinAlgError:
        return after
    better = state.copy()
    better[:states] += step
    if np.max(np.abs(turn(better) - better) / scale) < np.max(np.abs(turn(after) - after) / scale):
        return better
    return after


def _second_order(
    effect: Effect, p: tuple[float, ...], frequency: float, amplitude: float, time: float
) -> float:
    """Return the change of w^2 (1/s^2) by the even harmonics that a force of displacement adds to the motion.

    They answer the force as x = -f_0/w^2 + sum f_n cos(n theta) / ((n^2 - 1) w^2); the force along u + x is averaged
    again. For k2 u^2 this gives -5 k2^2 A^2 / (6 w^2) (Nayfeh and Mook 1979, 2.1).
    """
    angle = 2.0 * np.pi * (np.arange(2 * _POINTS + 1) + 1.0) / (2 * _POINTS)
    u, v = amplitude * np.cos(angle), -amplitude * frequency * np.sin(angle)
    address, clock = address_of_force(effect.force), np.full(len(angle), time)
    force = np.empty(_POINTS)

    def along(displacement: Array) -> Array:
        _cycle(address, 0, 0, clock, displacement, v, 0.0, 0.0, p, force)
        return force.copy()

    theta = angle[:-1:2]
    straight = along(u)
    order = np.arange(2, 13, 2)
    parts = np.array([2.0 * np.mean(straight * np.cos(n * theta)) for n in order])
    waves = np.cos(np.outer(angle, order))
    answer = waves @ (parts / ((order**2 - 1.0) * frequency**2)) - float(np.mean(straight)) / frequency**2
    largest = float(np.max(np.abs(answer)))
    if largest < 1e-9 * amplitude:
        return 0.0
    share = min(1.0, 1e-3 * amplitude / largest)
    change = (along(u + share * answer) - along(u - share * answer)) / (2.0 * share)
    shape = np.cos(theta)
    return float(np.mean(change * shape) / np.mean(shape**2) / amplitude)
