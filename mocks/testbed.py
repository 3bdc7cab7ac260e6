"""The testbed: a mass on springs with dry friction, integrated from event to event.

Slip in one direction, through one stretch between two kinks of the force, is smooth: RK4 takes
it in steps of a quarter of a millisecond. Reversals, kinks, breaking loose and the end of
the release are located to rounding and the integration starts anew there. A mass stays where it stops as
long as the other forces do not exceed the friction, exactly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mocks.compilation import compiled
from mocks.forces import FIRST_FRICTION, STATES, Effect, force, kinks, memory_rates, state_at_rest, table

STEP_S = 1.0 / 4096.0


@dataclass(frozen=True)
class Bench:
    """A mass on springs, per unit mass: `stiffness` 1/s^2, `mu_0` m/s^2, `mu_1` 1/s, `mass` kg."""

    stiffness: float = 614.0
    mu_0: float = 0.13
    mu_1: float = 0.277
    effects: tuple[Effect, ...] = ()
    mass: float = 21.36

    @property
    def angular_frequency(self) -> float:
        """Undamped angular frequency of the springs alone, rad/s."""
        return math.sqrt(self.stiffness)


@dataclass(frozen=True)
class Release:
    """How a release begins: `displacement` m, `velocity` m/s, and how long letting go takes, s.

    The holding force falls to nothing as half a cosine. With a velocity, a release that takes time
    is a push instead, a raised cosine of that length.
    """

    displacement: float = 0.0
    velocity: float = 0.0
    release_time: float = 0.0


@dataclass(frozen=True, eq=False)
class Trajectory:
    """The true motion at `time` (s since the release); `effects` (effect, time) in m/s^2."""

    time: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    effects: np.ndarray


def simulate(bench: Bench, release: Release, time: np.ndarray) -> Trajectory:
    """Return the true motion at any ascending times; at negative ones the mass is held still.

    The continuous solution is evaluated at each time; nothing is interpolated between samples.
    """
    time = np.ascontiguousarray(time, dtype=float)
    if time.size and np.any(np.diff(time) < 0.0):
        raise ValueError("the times must ascend")
    rows = table(bench.effects)
    out = np.empty((time.size, 3 + len(rows)))
    _run(
        time,
        np.array([bench.stiffness, bench.mu_0, bench.mu_1]),
        rows,
        kinks(bench.effects),
        state_at_rest(bench.effects, release.displacement),
        release.velocity,
        release.release_time,
        out,
    )
    return Trajectory(time, out[:, 0], out[:, 1], out[:, 2], out[:, 3:].T)


def simulate_channels(
    bench: Bench, release: Release, displacement_time: np.ndarray, acceleration_time: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return displacement and acceleration, each at its own true times, from one solution."""
    both = np.concatenate([displacement_time, acceleration_time])
    order = np.argsort(both, kind="stable")
    place = np.empty(both.size, dtype=int)
    place[order] = np.arange(both.size)
    motion = simulate(bench, release, both[order])
    n = len(displacement_time)
    return motion.displacement[place[:n]], motion.acceleration[place[n:]]


@compiled()
def _applied(t, hold, impulse, release_s):  # type: ignore[no-untyped-def]
    """Force applied during the release per unit mass at `t`."""
    if t >= release_s or t < 0.0:
        return 0.0
    if impulse != 0.0:
        return impulse / release_s * (1.0 - math.cos(2.0 * math.pi * t / release_s))
    return hold * 0.5 * (1.0 + math.cos(math.pi * t / release_s))


@compiled()
def _pull(base, rows, t, s, at, way, turned_at):  # type: ignore[no-untyped-def]
    """Sum of all forces on the left-applied side, dry friction included through `way`."""
    total = base[0] * s[0] + base[2] * s[1] + base[1] * way
    for i in range(rows.shape[0]):
        total += force(rows[i], base[0], t, s, at, way, turned_at)
    return total


@compiled()
def _net(base, rows, t, s, at, way, turned_at, applied):  # type: ignore[no-untyped-def]
    """Net force per unit mass at `t`: what is applied less all the others."""
    pull = _pull(base, rows, t, s, at, way, turned_at)
    return _applied(t, applied[0], applied[1], applied[2]) - pull


@compiled()
def _limit(base, rows, t, s, at):  # type: ignore[no-untyped-def]
    """Greatest friction the mass at rest can lean on."""
    total = base[1]
    for i in range(rows.shape[0]):
        if rows[i, 0] >= FIRST_FRICTION:
            total += force(rows[i], base[0], t, s, at, 1.0, s[0])
    return total


@compiled()
def _rates(base, rows, t, s, at, way, turned_at, applied, out):  # type: ignore[no-untyped-def]
    memory_rates(rows, s, way, out)
    if way == 0.0:
        out[0] = 0.0
        out[1] = 0.0
    else:
        out[0] = s[1]
        out[1] = _net(base, rows, t, s, at, way, turned_at, applied)


@compiled()
def _step(base, rows, t, h, s, at, way, turned_at, applied, work, new):  # type: ignore[no-untyped-def]
    """One classical RK4 step of length `h` from `s` into `new`."""
    k1, k2, k3, k4, x = work[0], work[1], work[2], work[3], work[4]
    _rates(base, rows, t, s, at, way, turned_at, applied, k1)
    for i in range(STATES):
        x[i] = s[i] + 0.5 * h * k1[i]
    _rates(base, rows, t + 0.5 * h, x, at, way, turned_at, applied, k2)
    for i in range(STATES):
        x[i] = s[i] + 0.5 * h * k2[i]
    _rates(base, rows, t + 0.5 * h, x, at, way, turned_at, applied, k3)
    for i in range(STATES):
        x[i] = s[i] + h * k3[i]
    _rates(base, rows, t + h, x, at, way, turned_at, applied, k4)
    for i in range(STATES):
        new[i] = s[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])


@compiled()
def _locate(which, level, base, rows, t, h, s, at, way, turned_at, applied, work, new):  # type: ignore[no-untyped-def]
    """Return the step after which state `which` has just passed `level` (Illinois' rule)."""
    lo, hi = 0.0, h
    f_lo = s[which] - level
    f_hi = new[which] - level
    last = 0
    for _ in range(60):
        if hi - lo <= 1e-15 + 1e-13 * h or f_hi == 0.0:
            break
        x = (lo * f_hi - hi * f_lo) / (f_hi - f_lo)
        if not (lo < x < hi):
            x = 0.5 * (lo + hi)
        _step(base, rows, t, x, s, at, way, turned_at, applied, work, new)
        f = new[which] - level
        if f * f_hi > 0.0 or f == 0.0:
            hi, f_hi = x, f
            if last == 1:
                f_lo *= 0.5
            last = 1
            if abs(f) < 1e-16:
                break
        else:
            lo, f_lo = x, f
            if last == -1:
                f_hi *= 0.5
            last = -1
    return hi


@compiled()
def _break_loose(base, rows, t, h, s, at, turned_at, applied, work, new):  # type: ignore[no-untyped-def]
    """Return the step after which the stuck mass has just lost its hold (bisection)."""
    lo, hi = 0.0, h
    for _ in range(48):
        x = 0.5 * (lo + hi)
        _step(base, rows, t, x, s, at, 0.0, turned_at, applied, work, new)
        net = _net(base, rows, t + x, new, at, 0.0, turned_at, applied)
        if abs(net) > _limit(base, rows, t + x, new, at):
            hi = x
        else:
            lo = x
    return hi


@compiled()
def _middle(levels, segment):  # type: ignore[no-untyped-def]
    """A point well inside a stretch between two kinks."""
    n = levels.size
    if n == 0:
        return 0.0
    if segment == 0:
        return levels[0] - 1.0
    if segment == n:
        return levels[n - 1] + 1.0
    return 0.5 * (levels[segment - 1] + levels[segment])


@compiled()
def _write(row, base, rows, t, s, at, way, turned_at, applied):  # type: ignore[no-untyped-def]
    row[0] = s[0]
    row[1] = s[1]
    row[2] = 0.0
    if way != 0.0:
        row[2] = _net(base, rows, t, s, at, way, turned_at, applied)
    for i in range(rows.shape[0]):
        row[3 + i] = force(rows[i], base[0], t, s, at, way, turned_at)


@compiled()
def _applied_forces(base, rows, s, at, velocity, release_s):  # type: ignore[no-untyped-def]
    """What is applied during the release: the force that holds the mass, or an impulse; and for how long."""
    applied = np.zeros(3)
    applied[2] = release_s
    if velocity == 0.0:
        applied[0] = _pull(base, rows, 0.0, s, at, 0.0, s[0])
    elif release_s > 0.0:
        applied[1] = velocity
    return applied


@compiled()
def _first_event(base, rows, levels, segment, t, h, s, at, way, turned_at, applied, work, new):  # type: ignore[no-untyped-def]
    """Cut a slipping step at its first event; return its length and 1 for a reversal, +-2 for a kink, 0 for none."""
    event = 0
    first = h
    if new[1] * way < 0.0:
        first = _locate(1, 0.0, base, rows, t, h, s, at, way, turned_at, applied, work, new)
        event = 1
        _step(base, rows, t, first, s, at, way, turned_at, applied, work, new)
    below = segment > 0 and new[0] < levels[segment - 1]
    above = segment < levels.size and new[0] > levels[segment]
    if below or above:
        level = levels[segment - 1] if below else levels[segment]
        first = _locate(0, level, base, rows, t, first, s, at, way, turned_at, applied, work, new)
        event = -2 if below else 2
        _step(base, rows, t, first, s, at, way, turned_at, applied, work, new)
    return first, event


@compiled()
def _run(times, base, rows, levels, start, velocity, release_s, out):  # type: ignore[no-untyped-def]
    """Walk from output time to output time, from event to event."""
    s = start.copy()
    new = start.copy()
    work = np.empty((5, STATES))
    segment = np.searchsorted(levels, s[0])
    at = _middle(levels, segment)
    turned_at = s[0]
    applied = _applied_forces(base, rows, s, at, velocity, release_s)
    index = 0
    while index < times.size and times[index] < 0.0:
        _write(out[index], base, rows, times[index], s, at, 0.0, turned_at, applied)
        index += 1
    t = way = 0.0
    if velocity != 0.0 and release_s == 0.0:
        s[1] = velocity
        way = 1.0 if velocity > 0.0 else -1.0
    while index < times.size:
        if way == 0.0:
            net = _net(base, rows, t, s, at, 0.0, turned_at, applied)
            if abs(net) > _limit(base, rows, t, s, at):
                way = 1.0 if net > 0.0 else -1.0
                turned_at = s[0]
        if times[index] <= t:
            _write(out[index], base, rows, times[index], s, at, way, turned_at, applied)
            index += 1
            continue
        h = min(STEP_S, times[index] - t)
        ends_at_output = h == times[index] - t
        if t < release_s < t + h:
            h = release_s - t
            ends_at_output = False
        _step(base, rows, t, h, s, at, way, turned_at, applied, work, new)
        if way == 0.0:
            net = _net(base, rows, t + h, new, at, 0.0, turned_at, applied)
            if abs(net) > _limit(base, rows, t + h, new, at):
                h = _break_loose(base, rows, t, h, s, at, turned_at, applied, work, new)
                _step(base, rows, t, h, s, at, 0.0, turned_at, applied, work, new)
                ends_at_output = False
            t = times[index] if ends_at_output else t + h
            s[:] = new
            continue
        if new[1] * way < 0.0 and s[1] == 0.0:
            way = 0.0  # The net force had not the strength to move it: it leans on friction.
            _step(base, rows, t, h, s, at, way, turned_at, applied, work, new)
            t = times[index] if ends_at_output else t + h
            s[:] = new
            continue
        first, event = _first_event(
            base, rows, levels, segment, t, h, s, at, way, turned_at, applied, work, new
        )
        t = times[index] if (event == 0 and ends_at_output) else t + first
        s[:] = new
        if event == 1:
            s[1] = 0.0
            way = 0.0  # The head of the loop decides between sticking and turning back.
            turned_at = s[0]
        elif event == 2 or event == -2:
            segment += 1 if event == 2 else -1
            at = _middle(levels, segment)
