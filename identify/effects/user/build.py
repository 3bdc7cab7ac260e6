"""Making a user's own effect of its formulas: a draft, of which what can be fitted is compiled, what cannot is refused."""

import ast
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import Any

import numpy as np

from identify.arrays import Array
from identify.effects.compiled import PARAMETERS, RATES, STATES, effect_function
from identify.effects.effect import Parameter
from identify.effects.force_effect import ForceEffect
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
from identify.effects.user.initial_values import combinations, problem_of, starts_of
from identify.effects.user.linearity import (
    Draw,
    Values,
    acting_together,
    check_values,
    points_near,
    proportion,
)

VARIABLES = ("t", "u", "v", "z0", "z1")
_MISTAKEN = {"x", "pos", "position", "displacement", "disp", "vel", "velocity", "speed", "xdot", "x_dot",
             "dx", "dxdt", "du", "dudt", "udot", "u_dot", "acceleration", "time"}  # fmt: skip
"""Names that somebody gives to displacement, velocity or time, not to a parameter."""

NAME = re.compile(r"[A-Za-z]\w{0,39}", re.ASCII)
_DRAWS = 12
_NO_UNIT = "no unit given: lengths, speeds, times and plain numbers are tried"


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


def finished(
    draft: Draft, listed: tuple[Parameter, ...], starts: dict[str, tuple[float, ...]]
) -> ForceEffect:
    """Return the effect of a draft, with the parameters and starting values that the user listed.

    ValueError, in a sentence, when it could not be fitted.
    """
    parameters = _parameters(draft, listed, starts)
    draw = _draw_of(parameters, starts)
    check_values(draft.name, draft.values, draw)
    _check_together(draft, draw)
    states = len(draft.rates)
    rates = None
    if states:
        padded = (*draft.rates, *[ZERO] * (STATES - states))
        rates = effect_function(to_compile(padded, draft.names), RATES, cache=False)
    settles = bool(states) and _comes_to_rest(rates, states, draw)
    even = _even(draft, draw)
    return ForceEffect(
        name=draft.name,
        title=f"{draft.name} (your own)",
        equation=draft.equation,
        parameters=parameters,
        symptom="what your formula says",
        confirming_test="a recording in which your formula predicts a large change",
        force=effect_function(draft.force, cache=False),
        friction=None if draft.friction is None else effect_function(draft.friction, cache=False),
        rates=rates,
        equilibrium_state=_rest_function(rates, states) if settles else None,
        states=states,
        fading_memory=settles or not states,
        starts=lambda scales: combinations(
            [starts_of(p, starts.get(p.name, ()), scales, even=p.name in even) for p in parameters[1:]]
        ),
        nonsmooth=True,
        of_time=draft.of_time,
    )


def _parameters(
    draft: Draft, listed: tuple[Parameter, ...], starts: dict[str, tuple[float, ...]]
) -> tuple[Parameter, ...]:
    given = {p.name: p for p in listed}
    for called in (*given, *starts):
        if called not in draft.names:
            raise ValueError(
                f"{draft.name}: {called} is no parameter of the formula; {', '.join(draft.names)} are"
            )
        problem = problem_of(given.get(called) or Parameter(called, "", ""), starts.get(called, ()))
        if problem is not None:
            raise ValueError(f"{draft.name}: {problem[1]}")
    inner = tuple(given.get(n) or Parameter(n, "", "" if n in starts else _NO_UNIT) for n in draft.names[1:])
    strength = given.get(draft.names[0]) or Parameter(draft.names[0], "", "strength")
    if draft.positive and strength.low < 0.0:
        strength = replace(strength, low=0.0)
    return (strength, *inner)


def _draw_of(parameters: tuple[Parameter, ...], starts: dict[str, tuple[float, ...]]) -> Draw:
    """Return a function that draws values of the parameters, inside their bounds and near where a fit begins."""

    def one(random: np.random.Generator, p: Parameter) -> float:
        if starts.get(p.name):
            return float(random.choice(starts[p.name]))
        low, high = p.low, p.high
        if isfinite(low) and isfinite(high):
            return float(low + (high - low) * random.uniform(0.1, 0.9))
        size = float(10.0 ** random.uniform(-0.7, 0.7))
        if low > -inf:
            return low + size * (abs(low) or 1.0)
        return high - size * (abs(high) or 1.0) if high < inf else size

    return lambda random: {p.name: one(random, p) for p in parameters}


def _check_together(draft: Draft, draw: Draw) -> None:
    together = acting_together(draft.values, draw)
    if not together:
        return
    if len(together) == 1:
        raise ValueError(f"{draft.name}: {together[0]} has no influence on the force; leave it out")
    if draft.scaled and draft.names[0] in together:
        raise ValueError(
            f"{draft.name}: the force is a sum in which each part has a strength of its own; write it as two effects, "
            "or as one strength times the rest, a*(u + r*v) for a*u + b*v"
        )
    raise ValueError(
        f"{draft.name}: {', '.join(together)} act only together, so no record can determine each of them; leave one out"
    )


def _even(draft: Draft, draw: Draw) -> frozenset[str]:
    """Return the inner parameters whose sign does not matter, but perhaps for the sign of the whole force."""
    random = np.random.default_rng(5)
    even = set(draft.names[1:])
    for _ in range(4):
        p = draw(random)
        points = points_near(random, p)
        once = draft.values(p, points)
        for name in tuple(even):
            other = draft.values(p | {name: -p[name]}, points)
            alike, turned = (
                [_same(a, sign * b) for a, b in zip(once, other, strict=True)] for sign in (1.0, -1.0)
            )
            if not all(alike) and not all((*turned[:2], *alike[2:])):
                even.discard(name)
    return frozenset(even)


def _same(first: Array, second: Array) -> bool:
    size = float(np.max(np.abs(np.nan_to_num(first)), initial=0.0))
    return bool(np.allclose(first, second, rtol=1e-9, atol=1e-12 * size, equal_nan=True))


def _comes_to_rest(rates: Any, states: int, draw: Draw) -> bool:
    """Check by the eigenvalues of their rates whether the internal states settle while the mass is held still."""
    from scipy.optimize import approx_fprime  # loaded when it is needed

    random = np.random.default_rng(2)
    for _ in range(_DRAWS):
        u, *z = random.uniform(-0.1, 0.1, 3)
        held = _rates_at(rates, states, u, np.array(list(draw(random).values())))
        slopes = np.reshape(approx_fprime(np.array(z[:states]), held), (states, states))
        if not np.isfinite(slopes).all():
            return False
        if not np.linalg.eigvals(slopes).real.max() < -1e-6 * max(float(np.max(np.abs(slopes))), 1e-300):
            return False
    return True


def _rest_function(rates: Any, states: int) -> Callable[[float, Array], tuple[float, float]]:
    """Return the function (u, p) of the states at which compiled rates vanish, sought from (u, 0); zeros without any."""
    from scipy.optimize import root  # loaded when it is needed

    def rest(u: float, p: Array) -> tuple[float, float]:
        found = root(_rates_at(rates, states, u, p), [u, 0.0][:states], tol=1e-12)
        z = [*found.x, 0.0] if found.success else [0.0, 0.0]
        return float(z[0]), float(z[1])

    return rest


def _rates_at(rates: Any, states: int, u: float, p: Array) -> Callable[[Array], Array]:
    """Return the rates (states,) of the states at a displacement and at parameters."""
    given = (*(float(x) for x in p), *[0.0] * (PARAMETERS - len(p)))

    def at(z: Array) -> Array:
        first, second = (*(float(x) for x in z), 0.0)[:2]
        return np.array(rates(0.0, u, 0.0, (first, second), given))[:states]

    return at
