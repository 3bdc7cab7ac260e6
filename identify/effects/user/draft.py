"""The draft of a user's own effect: its parameters, the strength first, and its parts, before anything is checked."""

import ast
import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from identify.arrays import Array
from identify.effects.compiled import PARAMETERS
from identify.effects.user.formula import (
    FUNCTIONS,
    ZERO,
    is_sign,
    is_slip_direction,
    names_in,
    over_arrays,
    slipping,
    times,
    to_compile,
)
from identify.effects.user.linearity import Values, proportion

VARIABLES = ("t", "u", "v", "z0", "z1")
_MISTAKEN = {"x", "pos", "position", "displacement", "disp", "vel", "velocity", "speed", "xdot", "x_dot",
             "dx", "dxdt", "du", "dudt", "udot", "u_dot", "acceleration", "time"}  # fmt: skip
"""Names that somebody gives to displacement, velocity or time, not to a parameter."""

NAME = re.compile(r"[A-Za-z]\w{0,39}", re.ASCII)


@dataclass(frozen=True, eq=False)
class Draft:
    """An effect before it is checked: its parameters, the strength first, and its parts as functions (t, u, v, z, p).

    `positive` says that the force is proportional for strengths from zero up only, `scaled` that the strength was put
    before a formula that had none, `of_time` that time stands in it.
    """

    name: str
    names: tuple[str, ...]
    values: Values
    force: Any
    friction: Any
    rates: tuple[ast.expr, ...]
    equation: str
    positive: bool
    scaled: bool
    of_time: bool


def from_formulas(name: str, force: ast.expr, rates: tuple[ast.expr, ...], equation: str) -> Draft:
    """Return the draft of an effect of formulas; what goes with sgn(v) is friction. ValueError when it is no effect."""
    names = _parameter_names(name, (force, *rates), len(rates))
    _check_slip(name, force)
    kinds = {n: proportion(_values_of((force, ZERO), names), names, n) for n in names}
    strength = next((n for kind in ("always", "from zero up") for n in names if kinds[n] == kind), "")
    scaled = not strength
    if scaled:
        strength = next(free for free in ("scale", "strength", "factor") if free not in names)
        force, equation = (
            times(ast.Name(strength, ast.Load(), col_offset=0), force),
            f"{strength} ({equation})",
        )
    names = (strength, *(n for n in names if n != strength))
    if len(names) > PARAMETERS:
        raise ValueError(
            f"{name}: {len(names)} parameters ({', '.join(names)}); at most {PARAMETERS} can be fitted"
        )
    smooth, level = slipping(force) or (force, None)
    return Draft(
        name=name,
        names=names,
        values=_values_of((smooth, level or ZERO, *rates), names),
        force=to_compile((smooth,), names),
        friction=None if level is None else to_compile((level,), names),
        rates=rates,
        equation=equation,
        positive=kinds.get(strength) == "from zero up",
        scaled=scaled,
        of_time=any(node.id == "t" for part in (force, *rates) for node in names_in(part)),
    )


def _values_of(parts: tuple[ast.expr, ...], names: tuple[str, ...]) -> Values:
    evaluate = over_arrays(parts, names)

    def values(p: dict[str, float], points: dict[str, Array]) -> tuple[Array, ...]:
        t, u, v, *z = (points[n] for n in VARIABLES)
        found = evaluate(t, u, v, z, [np.float64(p[n]) for n in names])
        return tuple(np.broadcast_to(part, u.shape) for part in found)

    return values


def _check_slip(name: str, formula: ast.expr) -> None:
    for node in ast.walk(formula):
        if is_sign(node) and not is_slip_direction(node) and any(below.id == "v" for below in names_in(node)):
            raise ValueError(
                f"{name}: character {node.col_offset}: dry friction is written with sgn(v) alone; of anything else with v "
                "in it the sign cannot be simulated (sgn(u*v) is sgn(u)*sgn(v))"
            )


def _parameter_names(name: str, formulas: tuple[ast.expr, ...], states: int) -> tuple[str, ...]:
    found = [node for formula in formulas for node in names_in(formula)]
    for node in found:
        where = f"{name}: character {node.col_offset}"
        if node.id.lower() in _MISTAKEN:
            raise ValueError(
                f"{where}: '{node.id}': displacement is u, velocity is v, time is t; other names are parameters"
            )
        if node.id in ("z0", "z1")[states:]:
            raise ValueError(f"{where}: {node.id} has no rate that says how it changes")
        if node.id in FUNCTIONS:
            raise ValueError(f"{where}: {node.id} is a function, {node.id}(...)")
        if not NAME.fullmatch(node.id):
            raise ValueError(f"{where}: '{node.id[:40]}' cannot be a parameter's name")
    return tuple(dict.fromkeys(node.id for node in found if node.id not in VARIABLES))
