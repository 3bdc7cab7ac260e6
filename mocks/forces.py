"""Every force the double's mass can feel, compiled, and how each one's memory begins.

The effects of the diagnosis' library are here under their names, written down a second time on
purpose, and beside them effects that no library has. A force stands on the left-hand side of
u'' = -(k u + mu_1 v + mu_0 sgn v + effects), so it is an acceleration (m/s^2).

Inside one step the branch a force takes is decided by where the step began (`at`, a point well
inside the current stretch between two kinks, and `way`, the direction of slip, 0 while stuck),
so that the integrator sees smooth functions only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit

#: name -> parameter names, in the order of the compiled table. The code is the position.
PARAMETERS: dict[str, tuple[str, ...]] = {
    "linear_stiffness": ("k",),
    "viscous_damping": ("mu_1",),
    "quadratic_damping": ("c2",),
    "cubic_damping": ("c3",),
    "position_dependent_damping": ("c12",),
    "cubic_stiffness": ("k3",),
    "quadratic_stiffness": ("k2",),
    "quintic_stiffness": ("k5",),
    "end_stop": ("ks", "gap", "side"),
    "freeplay": ("kf", "gap"),
    "bilinear_stiffness": ("kb",),
    "hysteresis": ("kh", "uy", "z_start"),
    "maxwell_element": ("k1", "tau"),
    "second_mass": ("ratio", "w2", "zeta"),
    "time_varying_stiffness": ("rate",),
    "harmonic_forcing": ("amp", "f", "phase"),
    "magnet": ("q", "at", "width"),
    "notched_spring": ("q", "at", "width"),
    "amplitude_switched_damping": ("c", "at"),
    "one_way_cable": ("kc",),
    "coulomb_friction": ("mu_0",),
    "stribeck_friction": ("dmu", "vs"),
    "position_dependent_friction": ("slope",),
    "fading_friction": ("dmu", "tau"),
    "one_sided_friction": ("dmu",),
    "adhesion": ("dmu", "length"),
}
NAMES = tuple(PARAMETERS)
CODE = {name: code for code, name in enumerate(NAMES)}
#: Outside the library of the diagnosis: it must say that it does not know them.
OUTSIDE_THE_LIBRARY = (
    "magnet",
    "notched_spring",
    "amplitude_switched_damping",
    "one_way_cable",
    "fading_friction",
    "one_sided_friction",
    "adhesion",
)
#: From this code on a force is dry friction: at rest it is a limit, not a force.
FIRST_FRICTION = CODE["coulomb_friction"]
COLUMNS = 4
STATES = 6  # u, v, z (hysteresis), q (Maxwell), y and its velocity (second mass)

(_K, _MU1, _C2, _C3, _C12, _K3, _K2, _K5, _STOP, _PLAY, _BILINEAR, _HYSTERESIS, _MAXWELL) = range(13)
(_SECOND, _DRIFT, _FORCING, _MAGNET, _NOTCH, _SWITCHED, _CABLE) = range(13, 20)
(_COULOMB, _STRIBECK, _BINDING, _FADING, _ONE_SIDED, _ADHESION) = range(20, 26)
_HYSTERESIS_CODE = _HYSTERESIS
_MAXWELL_CODE = _MAXWELL
_SECOND_CODE = _SECOND


@dataclass(frozen=True)
class Effect:
    """One force by name; `parameters` in SI units per unit mass (see `PARAMETERS`)."""

    name: str
    parameters: dict[str, float] = field(default_factory=dict)

    def row(self) -> list[float]:
        """Return the effect as a row of the compiled table."""
        if self.name not in CODE:
            raise ValueError(f"no effect is called {self.name!r}; there are: {', '.join(NAMES)}")
        known = PARAMETERS[self.name]
        wrong = set(self.parameters) ^ set(known)
        if wrong:
            raise ValueError(f"{self.name} takes {', '.join(known)}; check {', '.join(sorted(wrong))}")
        values = [float(self.parameters[p]) for p in known]
        return [float(CODE[self.name]), *values, *[0.0] * (COLUMNS - 1 - len(values))]


def table(effects: tuple[Effect, ...]) -> np.ndarray:
    """Return the effects as rows of (code, parameters...)."""
    return np.array([effect.row() for effect in effects], dtype=float).reshape(-1, COLUMNS)


def kinks(effects: tuple[Effect, ...]) -> np.ndarray:
    """Return the positions (m, ascending) at which a force bends or jumps."""
    at: set[float] = set()
    for effect in effects:
        p = effect.parameters
        if effect.name == "end_stop":
            at |= {p["gap"]} if p["side"] > 0 else {-p["gap"]} if p["side"] < 0 else {p["gap"], -p["gap"]}
        elif effect.name == "freeplay":
            at |= {p["gap"], -p["gap"]}
        elif effect.name == "amplitude_switched_damping":
            at |= {p["at"], -p["at"]}
        elif effect.name in {
            "bilinear_stiffness",
            "position_dependent_friction",
            "one_sided_friction",
            "one_way_cable",
        }:
            at.add(0.0)
    return np.array(sorted(at), dtype=float)


def state_at_rest(effects: tuple[Effect, ...], displacement: float) -> np.ndarray:
    """Return the state after a long hold at `displacement`: dampers and second mass at ease.

    Hysteresis begins at its parameter `z_start`, m: 0 if the hold has relaxed it,
    `pulled(displacement, uy)` if it remembers a slow pull from zero.
    """
    state = np.zeros(STATES)
    state[0] = state[3] = state[4] = displacement
    for effect in effects:
        if effect.name == "hysteresis":
            state[2] = effect.parameters["z_start"]
    return state


def pulled(displacement: float, yield_at: float) -> float:
    """Return the hysteresis' internal displacement after a slow pull: dz/du = 1 - (z/uy)^2."""
    return yield_at * math.tanh(displacement / yield_at)


@njit(cache=True)
def _friction(code, row, t, u, v, at, way, turned_at):  # type: ignore[no-untyped-def]
    """Return the dry friction of one effect times `way`."""
    a = row[1]
    if code == _COULOMB:
        return a * way
    if code == _STRIBECK:
        return a * math.exp(-((v / row[2]) ** 2)) * way
    if code == _BINDING:
        return a * (u if at > 0.0 else -u) * way
    if code == _FADING:
        return a * math.exp(-t / row[2]) * way
    if code == _ONE_SIDED:
        return a * way if at > 0.0 else 0.0
    return a * math.exp(-abs(u - turned_at) / row[2]) * way


@njit(cache=True)
def force(row, k, t, s, at, way, turned_at):  # type: ignore[no-untyped-def]
    """Return one effect's force; for dry friction its size times `way`.

    `row` code and parameters, `k` the spring's stiffness, `t` s since the release, `s` the
    state, `turned_at` the displacement of the last reversal.
    """
    code = int(row[0])
    u = s[0]
    v = s[1]
    a = row[1]
    if code == _K:
        return a * u
    if code == _MU1:
        return a * v
    if code == _C2:
        return a * v * v * way
    if code == _C3:
        return a * v * v * v
    if code == _C12:
        return a * u * u * v
    if code == _K3:
        return a * u * u * u
    if code == _K2:
        return a * u * u
    if code == _K5:
        return a * u**5
    if code == _STOP:
        if row[3] >= 0.0 and at > row[2]:
            return a * (u - row[2])
        if row[3] <= 0.0 and at < -row[2]:
            return a * (u + row[2])
        return 0.0
    if code == _PLAY:
        if at > row[2]:
            return -a * row[2]
        if at < -row[2]:
            return a * row[2]
        return -a * u
    if code == _BILINEAR:
        return a * u if at > 0.0 else 0.0
    if code == _HYSTERESIS:
        return a * s[2]
    if code == _MAXWELL:
        return a * (u - s[3])
    if code == _SECOND:
        return a * (row[2] * row[2] * (u - s[4]) + 2.0 * row[3] * row[2] * (v - s[5]))
    if code == _DRIFT:
        return k * a * t * u
    if code == _FORCING:
        return -a * math.sin(2.0 * math.pi * row[2] * t + row[3])
    if code == _MAGNET:
        return a / (1.0 + ((u - row[2]) / row[3]) ** 2)
    if code == _NOTCH:
        x = (u - row[2]) / row[3]
        return -a * x * math.exp(-x * x)
    if code == _SWITCHED:
        return a * v if abs(at) > row[2] else 0.0
    if code == _CABLE:
        return a * u if (at > 0.0 and way > 0.0) else 0.0
    return _friction(code, row, t, u, v, at, way, turned_at)


@njit(cache=True)
def memory_rates(rows, s, way, out):  # type: ignore[no-untyped-def]
    """Write the rates of the internal states (z, q, y and its velocity) into `out`."""
    for i in range(2, 6):
        out[i] = 0.0
    for i in range(rows.shape[0]):
        code = int(rows[i, 0])
        if code == _HYSTERESIS_CODE:
            z = s[2]
            loss = (z / rows[i, 2]) ** 2 if way * z > 0.0 else 0.0
            out[2] = s[1] * (1.0 - loss)
        elif code == _MAXWELL_CODE:
            out[3] = (s[0] - s[3]) / rows[i, 2]
        elif code == _SECOND_CODE:
            w2 = rows[i, 2]
            out[4] = s[5]
            out[5] = w2 * w2 * (s[0] - s[4]) + 2.0 * rows[i, 3] * w2 * (s[1] - s[5])
