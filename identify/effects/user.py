"""A user's own effect: a formula, or a few lines in a Python file."""

import ast
import re
from collections.abc import Callable
from itertools import product
from math import inf, isfinite
from typing import Any

import numpy as np
from numba import njit

from identify.effects.compiled import PARAMETERS, force_function, rate_function
from identify.effects.effect import Effect, Parameter, Scales
from identify.effects.expression import (
    FUNCTIONS,
    combined,
    compile_tree,
    names_in,
    parse_expression,
    with_slip_direction,
)

_KNOWN = ("t", "u", "v", "z0", "z1")
_MOST_STARTS = 48
_SETTING = re.compile(
    r"^\s*(?P<name>[A-Za-z]\w*)\s*(?::\s*(?P<unit>[^<>=\s]\S*))?"
    r"(?:\s*>=\s*(?P<low>\S+))?(?:\s*<=\s*(?P<high>\S+))?(?:\s+start\s+(?P<start>.+))?\s*$"
)
_SHARES = {
    "m": (0.1, 0.3, 0.6, -0.3, -0.6),
    "m/s": (0.1, 0.3, 0.6),
    "s": (0.3, 1.0, 3.0),
    "1": (0.5, 1.0, 2.0),
}
"""Starting values of an inner parameter, over the amplitude, the largest speed, the period, or 1."""


def parse_effect(text: str) -> Effect:
    """Return the effect that a line describes, such as `magnet = a*u/(1+(u/b)**2); b: m >= 0 start 0.002, 0.01`.

    Left of the sign stands the name, right of it the force per unit mass in t (s since the release), u, v and parameters
    of your own; `sgn(v)` makes its part dry friction. After a semicolon a parameter may have a unit, bounds and
    starting values. Raises ValueError, in a sentence, when it cannot be read.
    """
    first, *rest = text.split(";")
    name, sign, formula = first.partition("=")
    if not sign or not re.fullmatch(r"\s*[A-Za-z]\w*\s*", name):
        raise ValueError(f"'{first.strip()}' is not 'name = formula', such as 'magnet = a*u/(1 + (u/b)**2)'")
    settings: dict[str, Parameter] = {}
    starts: dict[str, tuple[float, ...]] = {}
    for part in rest:
        if part.strip():
            parameter, values = _setting(part)
            settings[parameter.name] = parameter
            if values:
                starts[parameter.name] = values
    return own_effect(name.strip(), force=formula.strip(), parameters=tuple(settings.values()), starts=starts)


def own_effect(
    name: str,
    force: str | Callable[..., float] = "",
    *,
    friction: str | Callable[..., float] = "",
    rates: tuple[str, ...] = (),
    parameters: tuple[Parameter, ...] = (),
    starts: dict[str, tuple[float, ...]] | None = None,
    title: str = "",
    tell: str = "",
    proof: str = "",
) -> Effect:
    """Return an effect of the user's own.

    `force` is a formula in t, u, v, z0, z1 and parameters, or a Python function of (t, u, v, z, p) that numba can
    compile (its parameters must then be listed); `friction` a formula of a level against the velocity; `rates` are
    formulas of the rates of up to two internal states z0 and z1. Parameters that are not listed have no unit and no
    bounds. The force must be proportional to one parameter; where it is to none, one called `scale` is put before it.
    """
    if name in FUNCTIONS or name in _KNOWN:
        raise ValueError(f"'{name}' has a meaning already; choose another name for the effect")
    if not force and not friction:
        raise ValueError(f"{name}: an effect needs a force or a friction")
    if callable(force) or callable(friction):
        return _from_functions(name, force, friction, parameters, starts or {}, title, tell, proof)
    tree = parse_expression(force) if force else parse_expression("0")
    level = parse_expression(friction) if friction else parse_expression("0")
    forth, back = with_slip_direction(tree, 1.0), with_slip_direction(tree, -1.0)
    level = combined(((0.5, forth), (-0.5, back), (1.0, level)))
    smooth = combined(((0.5, forth), (0.5, back)))
    states = tuple(parse_expression(rate) for rate in rates)
    if len(states) > 2:
        raise ValueError(f"{name}: at most two internal states, not {len(states)}")
    names = _parameter_names(
        name, (tree, parse_expression(friction) if friction else tree, *states), len(states)
    )
    names = _strength_first(names, (smooth, level))
    if names[0] == "scale" and "scale" not in names_in(combined(((1.0, smooth), (1.0, level)))):
        smooth, level = (_scaled(smooth), _scaled(level))
    listed = {p.name: p for p in parameters}
    unknown = set(listed) - set(names)
    if unknown:
        raise ValueError(
            f"{name}: {', '.join(sorted(unknown))} does not stand in the formula ({', '.join(names)} do)"
        )
    padded = (*states, *([parse_expression("0")] * (2 - len(states)))) if states else ()
    has_friction = bool(friction) or "sgn" in force or "sign" in force
    return _made(
        name,
        tuple(listed.get(n, Parameter(n, "", "")) for n in names),
        starts or {},
        force=force_function(compile_tree((smooth,), names), cache=False),
        friction=force_function(compile_tree((level,), names), cache=False) if has_friction else None,
        rates=rate_function(compile_tree(padded, names), cache=False) if padded else None,
        states=len(states),
        equation=" + ".join(part for part in (force, f"({friction}) sgn v" if friction else "") if part),
        title=title or f"{name} (your own)",
        tell=tell or "what your formula says",
        proof=proof or "a recording in which your formula predicts a large change",
    )


def _setting(part: str) -> tuple[Parameter, tuple[float, ...]]:
    found = _SETTING.match(part)
    if found is None:
        raise ValueError(f"'{part.strip()}' is not 'parameter: unit >= low <= high start value, value'")
    low, high = _number(found["low"], -inf, part), _number(found["high"], inf, part)
    if not low < high:
        raise ValueError(f"'{part.strip()}': the lower bound is not below the upper one")
    starts = tuple(_number(value, 0.0, part) for value in (found["start"] or "").split(",") if value.strip())
    return Parameter(found["name"], found["unit"] or "", "", low, high), starts


def _number(text: str | None, default: float, part: str) -> float:
    if text is None:
        return default
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"'{part.strip()}': '{text.strip()}' is not a number") from None


def _parameter_names(name: str, trees: tuple[ast.expr, ...], states: int) -> tuple[str, ...]:
    names = tuple(dict.fromkeys(n for tree in trees for n in names_in(tree) if n not in _KNOWN))
    for state in ("z0", "z1")[states:]:
        if any(state in names_in(tree) for tree in trees):
            raise ValueError(f"{name}: {state} stands in the formula, but no rate says how it changes")
    functions = [n for n in names if n in FUNCTIONS]
    if functions:
        raise ValueError(f"{name}: '{functions[0]}' is a function and cannot be a parameter")
    if len(names) > PARAMETERS:
        raise ValueError(f"{name}: {len(names)} parameters ({', '.join(names)}); at most {PARAMETERS}")
    return names


def _strength_first(names: tuple[str, ...], trees: tuple[ast.expr, ...]) -> tuple[str, ...]:
    """Return the names with one to which the force is proportional in front; `scale` where there is none."""
    function = (
        njit(error_model="numpy")(compile_tree((combined((1.0, tree) for tree in trees),), names))
        if names
        else None
    )
    random = np.random.default_rng(0)
    for i, name in enumerate(names):
        if function is not None and all(_proportional(function, i, len(names), random) for _ in range(6)):
            return (name, *(n for n in names if n != name))
    if len(names) >= PARAMETERS:
        raise ValueError(
            f"the force is proportional to none of {', '.join(names)}; at most {PARAMETERS - 1} such are read"
        )
    return ("scale", *names)


def _proportional(function: Any, place: int, count: int, random: np.random.Generator) -> bool:
    t, u, v = (float(x) for x in random.uniform(0.2, 1.5, 3))
    z = (0.3, 0.4)
    p = [float(x) for x in random.uniform(0.3, 2.0, count)]
    results = []
    for factor in (0.0, 1.0, 2.5):
        moved = list(p)
        moved[place] *= factor
        results.append(float(function(t, u, v, z, tuple(moved))))
    nothing, once, more = results
    if not all(map(isfinite, results)):
        return False
    return abs(nothing) < 1e-12 and once != 0.0 and abs(more - 2.5 * once) < 1e-9 * abs(once)


def _scaled(tree: ast.expr) -> ast.expr:
    return ast.BinOp(ast.Name("scale", ast.Load()), ast.Mult(), tree)


def _from_functions(
    name: str,
    force: str | Callable[..., float],
    friction: str | Callable[..., float],
    parameters: tuple[Parameter, ...],
    starts: dict[str, tuple[float, ...]],
    title: str,
    tell: str,
    proof: str,
) -> Effect:
    if not parameters:
        raise ValueError(f"{name}: a Python function needs its parameters listed, the strength first")
    if (isinstance(force, str) and force) or (isinstance(friction, str) and friction):
        raise ValueError(f"{name}: force and friction must both be formulas or both be functions")
    try:
        compiled = [force_function(f, cache=False) if callable(f) else None for f in (force, friction)]
    except (
        Exception
    ) as error:  # numba's errors have no common base; its first line says what it could not compile
        first = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
        raise ValueError(f"{name}: the function (t, u, v, z, p) cannot be compiled: {first}") from error
    return _made(
        name,
        parameters,
        starts,
        force=compiled[0],
        friction=compiled[1],
        equation=f"{name}(t, u, v)",
        title=title or f"{name} (your own)",
        tell=tell or "what your function says",
        proof=proof or "a recording in which your function predicts a large change",
    )


def _made(
    name: str, parameters: tuple[Parameter, ...], starts: dict[str, tuple[float, ...]], **fields: Any
) -> Effect:
    inner = parameters[1:]

    def all_starts(scales: Scales) -> tuple[tuple[float, ...], ...]:
        choices = [_starts_of(parameter, starts.get(parameter.name, ()), scales) for parameter in inner]
        return tuple(product(*choices))[:: max(1, int(np.prod([len(c) for c in choices])) // _MOST_STARTS)]

    return Effect(name=name, kind="physics", parameters=parameters, starts=all_starts, kinked=True, **fields)


def _starts_of(parameter: Parameter, given: tuple[float, ...], scales: Scales) -> tuple[float, ...]:
    if given:
        return given
    sizes = {"m": scales.amplitude, "m/s": scales.speed, "s": 1.0 / scales.frequency, "1": 1.0}
    units = (parameter.unit,) if parameter.unit in sizes else ("m", "m/s", "s", "1")
    values = tuple(share * sizes[unit] for unit in units for share in _SHARES[unit])
    inside = tuple(v for v in values if parameter.low <= v <= parameter.high)
    return inside or (0.5 * (max(parameter.low, -1e6) + min(parameter.high, 1e6)),)
