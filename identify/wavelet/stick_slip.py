"""Half cycles: the exact stick-slip decay of one mass, integrated from reversal to reversal."""

from dataclasses import dataclass
from math import ceil, pi, sqrt

import numpy as np

from identify.arrays import Array
from identify.compilation import compiled
from identify.errors import NotIdentifiable

_STEPS_PER_CYCLE = 100  # the frequency of a fourth-order step is then off by some 1e-8


_RUN_AWAY = 100.0  # times the first amplitude: no free decay grows so far


class RunsAway(NotIdentifiable):
    """The coefficients describe no free decay: the motion grows without end, or is no number at all."""

    def __init__(self) -> None:
        super().__init__(
            "with the stiffness and the damping of the envelope the motion would diverge; "
            "release from a smaller amplitude, or try lower orders"
        )


@dataclass(frozen=True, eq=False)
class Decay:
    """A computed decay: displacement, velocity and acceleration per sample, each of shape (n,)."""

    displacement: Array
    velocity: Array
    acceleration: Array


def simulate_decay(
    displacement: float, velocity: float, stiffness: Array, damping: Array, step: float, count: int
) -> Decay:
    """Integrate u'' = -sum k_i u^i - sgn(u') sum mu_i |u'|^i from a given state; `count` samples `step` s apart.

    `stiffness` holds k_1, k_2, ... (per unit mass, one entry for every order from 1), `damping` mu_0, mu_1, ....
    Each stretch between two reversals is smooth and integrated as such; the reversal is located; the mass sticks
    where the spring cannot overcome mu_0. Raises RunsAway where a coefficient is no finite number, k_1 lets the mass
    turn more than once between two samples, or the motion grows to a hundred times its start.
    """
    turn = step * sqrt(max(abs(stiffness[0]), 1e-300))
    given = np.concatenate([[displacement, velocity], stiffness, damping])
    if not np.isfinite(given).all() or turn > 2 * pi:
        raise RunsAway
    substeps = max(1, ceil(_STEPS_PER_CYCLE * turn / (2 * pi)))
    rows = _integrate(displacement, velocity, stiffness, damping, step, count, substeps)
    start = max(abs(displacement), abs(velocity) * step / turn)
    if not np.abs(rows[0]).max(initial=0.0) <= _RUN_AWAY * start:
        raise RunsAway
    return Decay(rows[0], rows[1], rows[2])


@compiled()
def _acceleration(u: float, v: float, direction: float, stiffness: Array, damping: Array) -> float:
    spring = 0.0
    for k in stiffness[::-1]:
        spring = (spring + k) * u
    loss = 0.0
    speed = direction * v
    for mu in damping[::-1]:
        loss = loss * speed + mu
    return -spring - direction * loss


@compiled()
def _advance(
    u: float, v: float, h: float, direction: float, stiffness: Array, damping: Array
) -> tuple[float, float]:
    a1 = _acceleration(u, v, direction, stiffness, damping)
    v2 = v + 0.5 * h * a1
    a2 = _acceleration(u + 0.5 * h * v, v2, direction, stiffness, damping)
    v3 = v + 0.5 * h * a2
    a3 = _acceleration(u + 0.5 * h * v2, v3, direction, stiffness, damping)
    v4 = v + h * a3
    a4 = _acceleration(u + h * v3, v4, direction, stiffness, damping)
    return u + h * (v + 2 * v2 + 2 * v3 + v4) / 6, v + h * (a1 + 2 * a2 + 2 * a3 + a4) / 6


@compiled()
def _time_of_reversal(
    u: float, v: float, h: float, direction: float, stiffness: Array, damping: Array
) -> float:
    low, high, guess = 0.0, h, 0.5 * h
    for _ in range(30):
        at_u, at_v = _advance(u, v, guess, direction, stiffness, damping)
        if direction * at_v > 0:
            low = guess
        else:
            high = guess
        slope = _acceleration(at_u, at_v, direction, stiffness, damping)
        following = guess - at_v / slope if slope != 0.0 else 0.5 * (low + high)
        if not low <= following <= high:
            following = 0.5 * (low + high)
        if abs(following - guess) < 1e-13 * h:
            return following
        guess = following
    return guess


@compiled()
def _integrate(
    u: float, v: float, stiffness: Array, damping: Array, step: float, count: int, substeps: int
) -> Array:
    rows = np.empty((3, count))
    h = step / substeps
    direction = np.sign(v)
    stuck = False
    none = np.zeros(1)
    if direction == 0.0:
        pull = _acceleration(u, 0.0, 1.0, stiffness, none)
        direction = np.sign(pull)
        stuck = abs(pull) <= damping[0]
    for i in range(count):
        rows[0, i] = u
        rows[1, i] = v
        rows[2, i] = 0.0 if stuck else _acceleration(u, v, direction, stiffness, damping)
        for _ in range(substeps):
            left = h
            for _reversal in range(4):
                if stuck:
                    break
                next_u, next_v = _advance(u, v, left, direction, stiffness, damping)
                if direction * next_v >= 0.0 or left <= 0.0:
                    u, v = next_u, next_v
                    break
                passed = _time_of_reversal(u, v, left, direction, stiffness, damping)
                u, v = _advance(u, v, passed, direction, stiffness, damping)
                v = 0.0
                left -= passed
                pull = _acceleration(u, 0.0, 1.0, stiffness, none)
                direction = np.sign(pull)
                stuck = abs(pull) <= damping[0]
    return rows
