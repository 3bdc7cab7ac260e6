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

from mocks.compilation import compiled

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
    "signed_quadratic_stiffness": ("k2a",),
    "end_stop": ("ks", "gap", "side"),
    "impact_with_loss": ("ks", "gap", "side", "loss"),
    "freeplay": ("kf", "gap"),
    "bilinear_stiffness": ("kb",),
    "hysteresis": ("kh", "uy", "z_start"),
    "dahl_friction": ("kd", "ud", "z_start"),
    "maxwell_element": ("k1", "tau"),
    "second_mass": ("ratio", "w2", "zeta"),
    "time_varying_stiffness": ("rate",),
    "settling_stiffness": ("r", "tau"),
    "harmonic_forcing": ("amp", "f", "phase"),
    "magnet": ("q", "at", "width"),
    "notched_spring": ("q", "at", "width"),
    "amplitude_switched_damping": ("c", "at"),
    "one_way_cable": ("kc",),
    "lugre_friction": ("kd", "ud", "rise", "vs", "z_start"),
    "power_law_stiffness": ("f", "p", "at"),
    "power_law_damping": ("f", "p", "at"),
    "bouc_wen_hysteresis": ("kh", "uy", "n", "z_start"),
    "fading_damping": ("c", "tau"),
    "wandering_stiffness": ("s", "walk"),
    "wandering_damping": ("s", "walk"),
    "coulomb_friction": ("mu_0",),
    "stribeck_friction": ("dmu", "vs"),
    "position_dependent_friction": ("slope",),
    "fading_friction": ("dmu", "tau"),
    "one_sided_friction": ("dmu",),
    "adhesion": ("dmu", "length"),
}
NAMES = tuple(PARAMETERS)
CODE = {name: code for code, name in enumerate(NAMES)}
#: Never the same twice: a random walk of standard deviation s after one second, the same for the same number `walk`.
WANDERS = ("wandering_stiffness", "wandering_damping")
#: Outside the library of the diagnosis: it must say that it does not know them.
OUTSIDE_THE_LIBRARY = (
    "magnet",
    "notched_spring",
    "amplitude_switched_damping",
    "one_way_cable",
    "one_sided_friction",
    "adhesion",
    *WANDERS,
)
#: Between the names of the library: laws with an exponent of their own, and LuGre's friction.
BETWEEN_THE_NAMES = ("lugre_friction", "power_law_stiffness", "power_law_damping", "bouc_wen_hysteresis")
#: From this code on a force is dry friction: at rest it is a limit, not a force.
FIRST_FRICTION = CODE["coulomb_friction"]
COLUMNS = 6
STATES = 8  # u, v, z (hysteresis), q (Maxwell), y and its velocity (second mass), z of Dahl or LuGre, z of Bouc-Wen
#: Where the internal displacement of a memory that begins at `z_start` lies in the state.
BEGINS_AT_Z = {"hysteresis": 2, "dahl_friction": 6, "lugre_friction": 6, "bouc_wen_hysteresis": 7}

(_K, _MU1, _C2, _C3, _C12, _K3, _K2, _K5, _K2A, _STOP, _IMPACT, _PLAY, _BILINEAR) = range(13)
(_HYSTERESIS, _DAHL, _MAXWELL, _SECOND, _DRIFT, _SETTLING, _FORCING) = range(13, 20)
(_MAGNET, _NOTCH, _SWITCHED, _CABLE, _LUGRE, _POWER_U, _POWER_V, _BOUC_WEN) = range(20, 28)
(_FADING_MU, _WANDERING_K, _WANDERING_MU) = range(28, 31)
(_COULOMB, _STRIBECK, _BINDING, _FADING, _ONE_SIDED, _ADHESION) = range(31, 37)
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
        if effect.name in {"end_stop", "impact_with_loss"}:
            at |= {p["gap"]} if p["side"] > 0 else {-p["gap"]} if p["side"] < 0 else {p["gap"], -p["gap"]}
        elif effect.name == "freeplay":
            at |= {p["gap"], -p["gap"]}
        elif effect.name == "amplitude_switched_damping":
            at |= {p["at"], -p["at"]}
        elif effect.name in {
            "bilinear_stiffness",
            "signed_quadratic_stiffness",
            "power_law_stiffness",
            "position_dependent_friction",
            "one_sided_friction",
            "one_way_cable",
        }:
            at.add(0.0)
    return np.array(sorted(at), dtype=float)


def state_at_rest(effects: tuple[Effect, ...], displacement: float) -> np.ndarray:
    """Return the state after a long hold at `displacement`: dampers and second mass at ease.

    Hysteresis and presliding friction begin at their parameter `z_start`, m: 0 if the hold has relaxed it,
    `pulled(displacement, uy)` if hysteresis remembers a slow pull from zero.
    """
    state = np.zeros(STATES)
    state[0] = state[3] = state[4] = displacement
    for effect in effects:
        if effect.name in BEGINS_AT_Z:
            state[BEGINS_AT_Z[effect.name]] = effect.parameters["z_start"]
    return state


def pulled(displacement: float, yield_at: float) -> float:
    """Return the hysteresis' internal displacement after a slow pull: dz/du = 1 - (z/uy)^2."""
    return yield_at * math.tanh(displacement / yield_at)


@compiled()
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


@compiled()
def _contact(code, row, u, v, at):  # type: ignore[no-untyped-def]
    """Return the force of play, or of a stop: stiffness times depth, with a loss more on the way in than out."""
    a = row[1]
    if code == _PLAY:
        if at > row[2]:
            return -a * row[2]
        if at < -row[2]:
            return a * row[2]
        return -a * u
    if row[3] >= 0.0 and at > row[2]:
        depth, inwards = u - row[2], v
    elif row[3] <= 0.0 and at < -row[2]:
        depth, inwards = u + row[2], -v
    else:
        return 0.0
    return a * depth * (1.0 + row[4] * inwards) if code == _IMPACT else a * depth


@compiled()
def _remembered(code, row, s):  # type: ignore[no-untyped-def]
    """Return the force of an effect with a memory."""
    if code == _MAXWELL:
        return row[1] * (s[0] - s[3])
    if code == _SECOND:
        w2 = row[2]
        return row[1] * (w2 * w2 * (s[0] - s[4]) + 2.0 * row[3] * w2 * (s[1] - s[5]))
    return row[1] * s[2 if code == _HYSTERESIS else 7 if code == _BOUC_WEN else 6]


#: A walk is a series of sines, which converges to it (Karhunen and Loeve), of so many terms, over so many seconds; no longer
#: release should have one.
_WALK_S, _WALK_TERMS = 16.0, 40


@compiled()
def _walk(t, number):  # type: ignore[no-untyped-def]
    """Return a random walk of variance t at `t` s; its coefficients are uniform numbers made of `number`."""
    total = 0.0
    for n in range(_WALK_TERMS):
        mixed = math.sin((n + 1.0) * 12.9898 + number * 78.233) * 43758.5453
        uniform = mixed - math.floor(mixed)
        rate = (n + 0.5) * math.pi / _WALK_S
        total += math.sqrt(12.0) * (uniform - 0.5) * math.sin(rate * t) / rate
    return total * math.sqrt(2.0 / _WALK_S)


@compiled()
def _wandering(code, row, k, t, u, v):  # type: ignore[no-untyped-def]
    """Return the force of a spring or a damper that wanders, in shares of `k` and of its root."""
    size = row[1] * _walk(t, row[2])
    return k * size * u if code == _WANDERING_K else math.sqrt(k) * size * v


@compiled()
def _power(code, row, u, v, at, way):  # type: ignore[no-untyped-def]
    """Return a force of a power law of displacement or of speed."""
    if code == _POWER_U:
        size = row[1] * abs(u / row[3]) ** row[2]
        return size if at > 0.0 else -size
    return row[1] * abs(v / row[3]) ** row[2] * way


@compiled()
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
    if code == _K2A:
        return a * u * u if at > 0.0 else -a * u * u
    if code in (_STOP, _IMPACT, _PLAY):
        return _contact(code, row, u, v, at)
    if code == _BILINEAR:
        return 0.5 * a * u if at > 0.0 else -0.5 * a * u
    if code in (_HYSTERESIS, _DAHL, _LUGRE, _BOUC_WEN, _MAXWELL, _SECOND):
        return _remembered(code, row, s)
    if code in (_WANDERING_K, _WANDERING_MU):
        return _wandering(code, row, k, t, u, v)
    if code in (_POWER_U, _POWER_V):
        return _power(code, row, u, v, at, way)
    if code == _DRIFT:
        return k * a * t * u
    if code == _SETTLING:
        return k * a * (1.0 - math.exp(-t / row[2])) * u
    if code == _FADING_MU:
        return a * math.exp(-t / row[2]) * v
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


@compiled()
def memory_rates(rows, s, way, out):  # type: ignore[no-untyped-def]
    """Write the rates of the internal states into `out`."""
    for i in range(2, STATES):
        out[i] = 0.0
    for i in range(rows.shape[0]):
        code = int(rows[i, 0])
        if code == _HYSTERESIS_CODE:
            z = s[2]
            loss = (z / rows[i, 2]) ** 2 if way * z > 0.0 else 0.0
            out[2] = s[1] * (1.0 - loss)
        elif code == _DAHL:
            out[6] = s[1] - s[1] * way * s[6] / rows[i, 2]
        elif code == _LUGRE:
            level = rows[i, 2] * (1.0 + rows[i, 3] * math.exp(-((s[1] / rows[i, 4]) ** 2)))
            out[6] = s[1] - s[1] * way * s[6] / level
        elif code == _BOUC_WEN:
            out[7] = s[1] * (1.0 - abs(s[7] / rows[i, 2]) ** rows[i, 3]) if way * s[7] > 0.0 else s[1]
        elif code == _MAXWELL_CODE:
            out[3] = (s[0] - s[3]) / rows[i, 2]
        elif code == _SECOND_CODE:
            w2 = rows[i, 2]
            out[4] = s[5]
            out[5] = w2 * w2 * (s[0] - s[4]) + 2.0 * rows[i, 3] * w2 * (s[1] - s[5])
