"""The draft of a user's own effect: its parameters, the strength first, and its parts, before anything is checked."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from identify.arrays import Array
from identify.effects.compiled import PARAMETERS, force_function
from identify.effects.user.expression import (
    FUNCTIONS,
    ZERO,
    Call,
    Name,
    Node,
    Number,
    is_slip_direction,
    minus,
    names_in,
    plus,
    slipping,
    times,
    walk,
)
from identify.effects.user.expression_code import over_arrays, python_function
from identify.effects.user.linearity import Values, drawn_points, strength_in
from identify.effects.user.python_function import along, compiled, parameters_of, placed

VARIABLES = ("t", "u", "v", "z0", "z1")
_MISTAKEN = {"x", "pos", "position", "displacement", "disp", "vel", "velocity", "speed", "xdot", "x_dot",
             "dx", "dxdt", "du", "dudt", "udot", "u_dot", "acceleration", "time"}  # fmt: skip
"""Names that somebody gives to displacement, velocity or time, not to a parameter."""

NAME = re.compile(r"[A-Za-z]\w{0,39}", re.ASCII)


@dataclass(frozen=True, eq=False)
class Draft:
    """An effect before it is checked: its parameters, the strength first, and its parts as functions (t, u, v, z, p).

    `positive` says that the force is proportional for strengths from zero up only, `scaled` that the strength was put
    before a formula that had none.
    """

    name: str
    names: tuple[str, ...]
    values: Values
    force: Any
    friction: Any
    rates: tuple[Node, ...]
    equation: str
    positive: bool
    scaled: bool = False


def from_formulas(name: str, force: Node, friction: Node, rates: tuple[Node, ...], equation: str) -> Draft:
    """Return the draft of an effect of formulas; what goes with sgn(v) joins the friction. ValueError when it is none."""
    names = _parameter_names(name, (force, friction, *rates), len(rates))
    _check_slip(name, (force, friction))
    everything = plus(force, times(friction, Call("sgn", (Name("v"),))) if friction != ZERO else ZERO)
    strength, order = strength_in(everything, names)
    scaled = not strength
    if scaled:
        strength = next(free for free in ("scale", "strength", "factor") if free not in names)
        everything, equation = times(Name(strength), everything), f"{strength} ({equation})"
    names = (strength, *(n for n in names if n != strength))
    if len(names) > PARAMETERS:
        raise ValueError(
            f"{name}: {len(names)} parameters ({', '.join(names)}); at most {PARAMETERS} can be fitted"
        )
    smooth: Node = everything
    level: Node = ZERO
    if any(is_slip_direction(node) for node in walk(everything)):
        forth, back = slipping(everything, 1.0), slipping(everything, -1.0)
        smooth, level = (times(Number(0.5), part) for part in (plus(forth, back), minus(forth, back)))

    def values(p: dict[str, float], points: dict[str, Array]) -> tuple[Array, ...]:
        known: dict[str, Array | float] = {**p, **points}
        shape = points["u"].shape
        return tuple(np.broadcast_to(over_arrays(node, known), shape) for node in (smooth, level, *rates))

    return Draft(
        name=name,
        names=names,
        values=values,
        force=None if _is_zero(values, names, 0) else python_function((smooth,), names),
        friction=None if level == ZERO else python_function((level,), names),
        rates=rates,
        equation=equation,
        positive=order == "positive",
        scaled=scaled,
    )


def _is_zero(values: Values, names: tuple[str, ...], part: int) -> bool:
    random = np.random.default_rng(3)
    return not any(
        values({n: float(random.uniform(0.3, 2.0)) for n in names}, drawn_points(random, 1.0))[part].any()
        for _ in range(3)
    )


def _check_slip(name: str, nodes: tuple[Node, ...]) -> None:
    for node in (below for tree in nodes for below in walk(tree)):
        if (
            isinstance(node, Call)
            and node.function == "sgn"
            and "v" in names_in(node)
            and not is_slip_direction(node)
        ):
            raise ValueError(
                f"{name}: character {node.at}: dry friction is written with sgn(v) alone; of anything else with v in it "
                "the sign cannot be simulated (sgn(u*v) is sgn(u)*sgn(v))"
            )


def _parameter_names(name: str, trees: tuple[Node, ...], states: int) -> tuple[str, ...]:
    found = [node for tree in trees for node in walk(tree) if isinstance(node, Name)]
    for node in found:
        if node.name.lower() in _MISTAKEN:
            raise ValueError(
                f"{name}: character {node.at}: '{node.name}': displacement is u, velocity is v, time is t; other names "
                "are parameters"
            )
        if node.name in ("z0", "z1")[states:]:
            raise ValueError(f"{name}: character {node.at}: {node.name} has no rate that says how it changes")
        if node.name in FUNCTIONS:
            raise ValueError(f"{name}: character {node.at}: {node.name} is a function, {node.name}(...)")
        if not NAME.fullmatch(node.name):
            raise ValueError(f"{name}: character {node.at}: '{node.name[:40]}' cannot be a parameter's name")
    return tuple(dict.fromkeys(node.name for node in found if node.name not in VARIABLES))


def from_functions(
    name: str,
    force: str | Callable[..., float],
    friction: str | Callable[..., float],
    rates: tuple[Node, ...],
    listed: tuple[str, ...],
) -> Draft:
    """Return the draft of an effect of Python functions, compiled; ValueError when they are of another kind."""
    if (isinstance(force, str) and force) or (isinstance(friction, str) and friction):
        raise ValueError(f"{name}: force and friction must both be formulas or both be functions")
    functions = tuple(f if callable(f) else None for f in (force, friction))
    try:
        found = [parameters_of(f, listed) for f in functions if f is not None]
        names = tuple(
            dict.fromkeys([*(n for part in found for n in part), *_parameter_names(name, rates, len(rates))])
        )
        if len(names) > PARAMETERS:
            raise ValueError(
                f"{len(names)} parameters ({', '.join(names)}); at most {PARAMETERS} can be fitted"
            )
        made = [None if f is None else compiled(force_function, placed(f, names)) for f in functions]
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from error

    def values(p: dict[str, float], points: dict[str, Array]) -> tuple[Array, ...]:
        ordered = {n: p[n] for n in names}
        parts = [
            np.zeros(len(points["u"])) if f is None else along(f, PARAMETERS, points, ordered) for f in made
        ]
        shape = points["u"].shape
        return (*parts, *(np.broadcast_to(over_arrays(rate, {**p, **points}), shape) for rate in rates))

    return Draft(
        name=name,
        names=names,
        values=values,
        force=made[0],
        friction=made[1],
        rates=rates,
        equation=f"{name}(t, u, v)",
        positive=_check_proportion(name, names, values),
    )


def _check_proportion(name: str, names: tuple[str, ...], values: Values) -> bool:
    """Return whether a force is proportional to its first parameter from zero up only; ValueError if not even there."""
    random = np.random.default_rng(4)
    positive = False
    for _ in range(3):
        p = {n: float(random.uniform(0.3, 2.0)) for n in names}
        points = drawn_points(random, 0.1)
        once = np.concatenate(values(p, points)[:2])
        size = float(np.max(np.abs(once), initial=0.0))
        for factor in (2.5, 0.0, -1.0):
            other = np.concatenate(values(p | {names[0]: factor * p[names[0]]}, points)[:2])
            same = np.abs(other - factor * once) <= 1e-9 * size
            if same[np.isfinite(once)].all():
                continue
            if factor >= 0.0:
                raise ValueError(
                    f"{name}: the force must be proportional to its first parameter, and is not to {names[0]}"
                )
            positive = True
    return positive
