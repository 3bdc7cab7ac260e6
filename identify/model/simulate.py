"""The simulator: free motion under a sum of effects, exact in stick and slip.

Fixed steps of the classical fourth-order Runge-Kutta method run in one direction of slip until the velocity
crosses zero; the crossing is located, the mass sticks if friction can hold the other forces, and goes on
in the new direction otherwise. Readings between steps come from the quintic Hermite polynomial through
position, velocity and acceleration at both ends of the step, so that a late channel costs nothing.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identify.arrays import Array
from identify.compilation import compiled
from identify.effects.compiled import RATES, address_of, call_force, call_rates
from identify.effects.force_effect import ForceEffect

_STEP_ANGLE = 0.055
_STEP_ANGLE_KINKED = 0.027
_REVERSAL_TRIALS = 8
_EVENTS_PER_STEP = 16
_COMPILE: dict[str, Any] = {"nogil": True, "error_model": "numpy", "_nrt": False}
"""Without numba's count of references, which no array here needs: it would take half of the time."""
_INLINE: dict[str, Any] = {**_COMPILE, "forceinline": True}


@dataclass(frozen=True, eq=False)
class System:
    """A model made ready to run: the addresses of force, friction and rates of each effect, shape (effects, 3).

    Whether some effect is `nonsmooth`, `has_friction`, or `has_memory`, that is internal states.
    """

    addresses: NDArray[np.int64]
    nonsmooth: bool
    has_friction: bool
    has_memory: bool


@dataclass(frozen=True, eq=False)
class Response:
    """Displacement and velocity at `time - lag`, acceleration at `time`: shape (n,) each, SI."""

    displacement: Array
    velocity: Array
    acceleration: Array


@compiled(**_INLINE)
def _acceleration(addresses, t, u, v, states, s, linear, table, drive):  # type: ignore[no-untyped-def]
    total = linear[0] * u + linear[1] * v - drive
    level = linear[2]
    for i in range(addresses.shape[0]):
        if addresses[i, 0] != 0 or addresses[i, 1] != 0:
            z = (0.0, 0.0) if states is None else (states[i, 0], states[i, 1])
            p = (table[i, 0], table[i, 1], table[i, 2], table[i, 3], table[i, 4], table[i, 5])
            if addresses[i, 0] != 0:
                total += call_force(addresses[i, 0], t, u, v, z, p)
            if addresses[i, 1] != 0:
                level += call_force(addresses[i, 1], t, u, v, z, p)
    level = max(level, min(linear[2], 0.0))
    return -total - s * level, total, level


@compiled(**_INLINE)
def _state_rates(addresses, t, u, v, states, table, out):  # type: ignore[no-untyped-def]
    for i in range(addresses.shape[0]):
        if addresses[i, 2] != 0:
            z = (states[i, 0], states[i, 1])
            p = (table[i, 0], table[i, 1], table[i, 2], table[i, 3], table[i, 4], table[i, 5])
            out[i, 0], out[i, 1] = call_rates(addresses[i, 2], t, u, v, z, p)


@compiled(**_INLINE)
def _blend(addresses, states, factor, slope, out):  # type: ignore[no-untyped-def]
    for i in range(addresses.shape[0]):
        if addresses[i, 2] != 0:
            out[i, 0] = states[i, 0] + factor * slope[i, 0]
            out[i, 1] = states[i, 1] + factor * slope[i, 1]


@compiled(**_INLINE)
def _step(addresses, t, u, v, a, states, s, h, linear, table, drives, work):  # type: ignore[no-untyped-def]
    """One Runge-Kutta step of length h from (u, v, states) with acceleration a; new states go to work[4]."""
    half = 0.5 * h
    new = None if work is None else work[4]
    if work is not None:
        _state_rates(addresses, t, u, v, states, table, work[0])
        _blend(addresses, states, half, work[0], work[4])
    u2 = u + half * v
    v2 = v + half * a
    a2 = _acceleration(addresses, t + half, u2, v2, new, s, linear, table, drives[1])[0]
    if work is not None:
        _state_rates(addresses, t + half, u2, v2, work[4], table, work[1])
        _blend(addresses, states, half, work[1], work[4])
    u3 = u + half * v2
    v3 = v + half * a2
    a3 = _acceleration(addresses, t + half, u3, v3, new, s, linear, table, drives[1])[0]
    if work is not None:
        _state_rates(addresses, t + half, u3, v3, work[4], table, work[2])
        _blend(addresses, states, h, work[2], work[4])
    u4 = u + h * v3
    v4 = v + h * a3
    a4 = _acceleration(addresses, t + h, u4, v4, new, s, linear, table, drives[2])[0]
    if work is not None:
        _state_rates(addresses, t + h, u4, v4, work[4], table, work[3])
        for i in range(addresses.shape[0]):
            if addresses[i, 2] != 0:
                for j in (0, 1):
                    slope = work[0, i, j] + 2.0 * (work[1, i, j] + work[2, i, j]) + work[3, i, j]
                    work[4, i, j] = states[i, j] + h / 6.0 * slope
    return u + h / 6.0 * (v + 2.0 * (v2 + v3) + v4), v + h / 6.0 * (a + 2.0 * (a2 + a3) + a4)


@compiled(**_INLINE)
def hermite(x, h, u0, v0, a0, u1, v1, a1):  # type: ignore[no-untyped-def]
    """Quintic through both ends of a step of length h, at fraction x: value and slope."""
    d1 = v0 * h
    d2 = 0.5 * a0 * h * h
    e0 = u1 - u0 - d1 - d2
    e1 = v1 * h - d1 - 2.0 * d2
    e2 = a1 * h * h - 2.0 * d2
    c3 = 10.0 * e0 - 4.0 * e1 + 0.5 * e2
    c4 = -15.0 * e0 + 7.0 * e1 - e2
    c5 = 6.0 * e0 - 3.0 * e1 + 0.5 * e2
    value = u0 + x * (d1 + x * (d2 + x * (c3 + x * (c4 + x * c5))))
    slope = d1 + x * (2.0 * d2 + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5)))
    return value, slope / h


@compiled(**_INLINE)
def _drive(external, position):  # type: ignore[no-untyped-def]
    """Recorded external force at a fractional sample, by the cubic through four neighbours (Catmull-Rom)."""
    n = external.shape[0]
    i = min(max(int(position), 0), n - 2)
    x = position - i
    p1 = external[i]
    p2 = external[i + 1]
    p0 = external[i - 1] if i > 0 else 2.0 * p1 - p2
    p3 = external[i + 2] if i + 2 < n else 2.0 * p2 - p1
    return p1 + 0.5 * x * (
        p2 - p0 + x * (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3 + x * (3.0 * (p1 - p2) + p3 - p0))
    )


@compiled(**_INLINE)
def _direction_of_slip(addresses, t, u, states, linear, table, drive):  # type: ignore[no-untyped-def]
    """At zero velocity: the direction in which the mass will slip (0 where friction holds it), and the acceleration."""
    _, total, level = _acceleration(addresses, t, u, 0.0, states, 0.0, linear, table, drive)
    if abs(total) <= level:
        return 0.0, 0.0
    s = -np.sign(total)
    return s, -total - s * level


@compiled(**_INLINE)
def _hold(addresses, t, u, step, states, table, work):  # type: ignore[no-untyped-def]
    """Internal states after a step in which the mass sticks, into work[4]."""
    _state_rates(addresses, t, u, 0.0, states, table, work[0])
    _blend(addresses, states, 0.5 * step, work[0], work[4])
    _state_rates(addresses, t + 0.5 * step, u, 0.0, work[4], table, work[1])
    _blend(addresses, states, step, work[1], work[4])


@compiled(**_COMPILE)
def _until_reversal(  # type: ignore[no-untyped-def]
    addresses, t, u, v, a, states, s, step, vn, h, linear, table, work, external, position, interval,
):  # fmt: skip
    """Length of the step after which the velocity is zero, and the displacement there, by false position."""
    low, high, vlow, vhigh, un, guess = 0.0, step, v, vn, u, step
    for _ in range(_REVERSAL_TRIALS):
        guess = low + (high - low) * vlow / (vlow - vhigh)
        guess = min(max(guess, low + 1e-3 * (high - low)), high - 1e-3 * (high - low))
        drives = _drives(external, position, guess / interval)
        un, vn = _step(addresses, t, u, v, a, states, s, guess, linear, table, drives, work)
        if abs(vn) <= 1e-9 * (abs(a) * h + 1e-300):
            break
        if vn * s > 0.0:
            low, vlow = guess, vn
        else:
            high, vhigh = guess, vn
    return guess, un


@compiled(**_INLINE)
def _drives(external, position, length):  # type: ignore[no-untyped-def]
    """Return the recorded force at the start, in the middle and at the end of a step of `length` samples; 0 if none acts."""
    if external is None:
        return 0.0, 0.0, 0.0
    return (
        _drive(external, position),
        _drive(external, position + 0.5 * length),
        _drive(external, position + length),
    )


@compiled(**_INLINE)
def _take_over(addresses, found, states):  # type: ignore[no-untyped-def]
    """Copy the internal states that a step found."""
    for i in range(addresses.shape[0]):
        if addresses[i, 2] != 0:
            states[i, 0], states[i, 1] = found[i, 0], found[i, 1]


@compiled(**_INLINE)
def _read_before(readings, interval, lag, u, v, a):  # type: ignore[no-untyped-def]
    """Fill in the samples that a late channel reads before the start, by its acceleration; return the next one."""
    due = 0
    while due < readings.shape[1] and due * interval - lag <= 0.0:
        ahead = due * interval - lag
        readings[0, due] = u + ahead * (v + 0.5 * ahead * a)
        readings[1, due] = v + ahead * a
        due += 1
    return due


@compiled(**_COMPILE)
def _run(  # type: ignore[no-untyped-def]
    addresses, dry, t0, n, interval, substeps, u, v, states, linear, table, lag, external, readings, work,
):  # fmt: skip
    """Write displacement, velocity and acceleration at the samples into `readings` (3, n).

    `states` and `work` are None where nothing remembers, `external` where no force is recorded: numba then leaves out
    what serves them.
    """
    h = interval / substeps
    drives = _drives(external, 0.0, 0.0)
    s = np.sign(v) if dry else 0.0
    if dry and s == 0.0:
        s, a = _direction_of_slip(addresses, t0, u, states, linear, table, drives[0])
    else:
        a = _acceleration(addresses, t0, u, v, states, s, linear, table, drives[0])[0]
    due = _read_before(readings, interval, lag, u, v, a)
    for i in range(n):
        readings[2, i] = a
        if i == n - 1 and due >= n:
            break
        for k in range(substeps):
            t = t0 + i * interval + k * h
            remaining, start = h, t
            for _ in range(_EVENTS_PER_STEP):
                t = start + (h - remaining)
                step, crossed, stuck = remaining, False, dry and s == 0.0
                position = 0.0 if external is None else (t - t0) / interval
                drives = _drives(external, position, step / interval)
                un, vn, an = u, 0.0, 0.0
                if work is not None and stuck:
                    _hold(addresses, t, u, step, states, table, work)
                if not stuck:
                    un, vn = _step(addresses, t, u, v, a, states, s, step, linear, table, drives, work)
                    crossed = dry and vn * s < 0.0
                if crossed:
                    vn, (step, un) = 0.0, _until_reversal(
                        addresses, t, u, v, a, states, s, step, vn, h, linear, table, work, external, position, interval,
                    )  # fmt: skip
                    drives = _drives(external, position, step / interval)
                if work is not None:
                    _take_over(addresses, work[4], states)
                if not stuck:
                    an = _acceleration(addresses, t + step, un, vn, states, s, linear, table, drives[2])[0]
                while due < n and due * interval - lag <= t + step - t0 + 1e-12:
                    x = (due * interval - lag - (t - t0)) / step
                    readings[0, due], readings[1, due] = hermite(x, step, u, v, a, un, vn, an)
                    due += 1
                u, v, a = un, vn, an
                if crossed or stuck:
                    s, a = _direction_of_slip(addresses, t + step, u, states, linear, table, drives[2])
                remaining -= step
                if remaining <= 1e-9 * h:
                    break
            if not (abs(u) < 1e12):
                readings[:2, due:] = np.inf
                readings[2, i + 1 :] = np.inf
                return
    for i in range(due, n):  # an early channel ends after the run
        ahead = (i - n) * interval - lag
        readings[0, i] = u + ahead * (v + 0.5 * ahead * a)
        readings[1, i] = v + ahead * a


def substeps_for(frequency: float, rate: float, *, nonsmooth: bool, longer: float = 1.0) -> int:
    """Count the integration steps a sample needs for an angular frequency in rad/s at a rate in Hz.

    Steps `longer` by a factor are for a motion that need not be followed to below the noise.
    """
    angle = (_STEP_ANGLE_KINKED if nonsmooth else _STEP_ANGLE) * longer
    return max(1, int(np.ceil(frequency / (rate * angle))))


def simulate(
    system: System,
    linear: Array,
    table: Array,
    *,
    start: tuple[float, float],
    states: Array,
    samples: int,
    rate: float,
    substeps: int,
    time: float = 0.0,
    lag: float = 0.0,
    external: Array | None = None,
) -> Response:
    """Run the motion from `start` = (displacement m, velocity m/s) at `time` s after the release.

    `linear` is (k 1/s^2, mu_1 1/s, mu_0 m/s^2), negative too; `table` (slots, 6) holds the parameters of the slots, `states`
    (slots, 2) their internal states at the start; `external` (samples,) a recorded force per unit mass. Displacement
    and velocity are read at `lag` s before each sample. A motion that diverges is filled with inf.
    """
    dry = bool(linear[2] != 0.0 or system.has_friction)
    readings = np.empty((3, samples))
    forced = external is not None and len(external) > 1
    memory = system.has_memory or forced
    _run(
        system.addresses,
        dry,
        time,
        samples,
        1.0 / rate,
        substeps,
        start[0],
        start[1],
        np.array(states, dtype=np.float64) if memory else None,
        linear,
        table,
        lag,
        external if forced else None,
        readings,
        np.zeros((5, len(system.addresses), 2)) if memory else None,
    )
    return Response(readings[0], readings[1], readings[2])


def make_system(effects: tuple[ForceEffect, ...]) -> System:
    """Make effects (beyond the linear part and Coulomb friction) ready for the simulator."""
    addresses = np.zeros((len(effects), 3), dtype=np.int64)
    for row, effect in zip(addresses, effects, strict=True):
        row[:] = address_of(effect.force), address_of(effect.friction), address_of(effect.rates, RATES)
    nonsmooth = any(effect.nonsmooth for effect in effects)
    return System(addresses, nonsmooth, bool(addresses[:, 1].any()), bool(addresses[:, 2].any()))
