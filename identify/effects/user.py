"""A user's own effect: a formula on the command line, or a few lines in a Python file."""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import Any

import numpy as np

from identify.arrays import Array
from identify.effects.compiled import PARAMETERS, STATES, force_function, rate_function
from identify.effects.effect import Effect, Parameter, Scales
from identify.effects.expression import (
    CONSTANTS,
    FUNCTIONS,
    ZERO,
    Call,
    Name,
    Node,
    Number,
    is_slip_direction,
    minus,
    names_in,
    parse_expression,
    plus,
    slipping,
    times,
    walk,
)
from identify.effects.expression_code import over_arrays, python_function
from identify.effects.library import LIBRARY
from identify.effects.own_function import along, compiled, parameters_of, placed
from identify.effects.own_memory import comes_to_rest, rest_function
from identify.effects.own_settings import OwnSetting, read_setting
from identify.effects.own_starts import combinations, dimensions_of, starts_of
from identify.effects.proportion import (
    Values,
    acting_together,
    check_values,
    drawn_points,
    points_near,
    strength_in,
)

_VARIABLES = ("t", "u", "v", "z0", "z1")
_NAME = re.compile(r"[A-Za-z]\w{0,39}", re.ASCII)
_LONGEST_LINE = 1000
_NO_UNIT = "no unit given: lengths, speeds, times and plain numbers are tried"

Draw = Callable[[np.random.Generator], dict[str, float]]


@dataclass(frozen=True, eq=False)
class _Draft:
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


@force_function
def _nothing(t, u, v, z, p):  # type: ignore[no-untyped-def]
    return 0.0


def parse_effect(text: str) -> Effect:
    """Return the effect that a line describes, such as `magnet = a*u/(1 + (u/b)**2); b: m >= 0 start 0.002, 0.01`.

    Left of the sign stands the name, right of it the force per unit mass in t (s since the release), u, v and parameters
    of your own; what multiplies `sgn(v)` is dry friction. After semicolons a parameter may have a unit, bounds and
    starting values (see `own_settings`). Raises ValueError, in a sentence with the place, when it cannot be read.
    """
    if len(text) > _LONGEST_LINE:
        raise ValueError(f"the line has {len(text)} characters; at most {_LONGEST_LINE} are read")
    first, *rest = text.split(";")
    left, sign, formula = first.partition("=")
    name = left.strip()
    if not sign or not name:
        raise ValueError(
            f"'{first.strip()[:60]}' is not 'name = formula', such as 'magnet = a*u/(1 + (u/b)**2)'"
        )
    _check_name(name)
    settings: list[OwnSetting] = []
    before = len(first) + 1
    for part in rest:
        if part.strip():
            settings.append(read_setting(part.rstrip(), before=before))
        before += len(part) + 1
    draft = _from_formulas(name, parse_expression(formula, before=len(left) + 1), ZERO, (), formula.strip())
    for i, setting in enumerate(settings):
        called = setting.parameter.name
        if called not in draft.names:
            raise ValueError(f"character {setting.at}: {called} does not stand in the formula of {name}")
        if called in (earlier.parameter.name for earlier in settings[:i]):
            raise ValueError(f"character {setting.at}: {called} is set twice")
    return _finished(
        draft,
        tuple(setting.parameter for setting in settings),
        {setting.parameter.name: setting.starts for setting in settings if setting.starts},
    )


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

    `force` and `friction` (a level >= 0 against the velocity) are both formulas in t, u, v, z0, z1 and parameters, or
    both Python functions of (t, u, v, parameters...) that numba can compile, their strength first; `rates` are formulas
    of the rates of up to two internal states z0 and z1. `parameters` gives units, meanings and bounds,
    `starts` starting values of inner parameters. The force must be proportional to one parameter; a formula that
    is to none has one called `scale` put before it. Raises ValueError, in a sentence, when it cannot be used.
    """
    _check_name(name)
    if not force and not friction:
        raise ValueError(f"{name}: an effect needs a force or a friction")
    if len(rates) > STATES:
        raise ValueError(f"{name}: at most {STATES} internal states, not {len(rates)}")
    changes = tuple(_parsed(name, f"rate {i + 1}", rate) for i, rate in enumerate(rates))
    if callable(force) or callable(friction):
        draft = _from_functions(name, force, friction, changes, tuple(p.name for p in parameters))
    else:
        pull, level = _parsed(name, "force", force), _parsed(name, "friction", friction)
        dry = f"({friction}) sgn(v)" if friction else ""
        draft = _from_formulas(
            name, pull, level, changes, " + ".join(x for x in (str(force).strip(), dry) if x)
        )
    return _finished(draft, parameters, starts or {}, title=title, tell=tell, proof=proof)


def _check_name(name: str) -> None:
    if not _NAME.fullmatch(name):
        raise ValueError(
            f"'{name[:40]}' cannot be an effect's name; write letters, digits and _, a letter first"
        )
    if name in FUNCTIONS or name in _VARIABLES or name in CONSTANTS:
        raise ValueError(f"'{name}' has a meaning in formulas; choose another name for the effect")
    if any(effect.name == name for effect in LIBRARY):
        raise ValueError(
            f"{name} is in the library already; choose another name, or add it without a formula"
        )


def _parsed(name: str, what: str, text: object) -> Node:
    if not isinstance(text, str):
        raise ValueError(f"{name}: the {what} must be a formula, not {type(text).__name__}")
    try:
        return parse_expression(text) if text.strip() else ZERO
    except ValueError as error:
        raise ValueError(f"{name}: {what}, {error}") from error


def _from_formulas(name: str, force: Node, friction: Node, rates: tuple[Node, ...], equation: str) -> _Draft:
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

    return _Draft(
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
        if node.name in ("z0", "z1")[states:]:
            raise ValueError(f"{name}: character {node.at}: {node.name} has no rate that says how it changes")
        if node.name in FUNCTIONS:
            raise ValueError(f"{name}: character {node.at}: {node.name} is a function, {node.name}(...)")
        if not _NAME.fullmatch(node.name):
            raise ValueError(f"{name}: character {node.at}: '{node.name[:40]}' cannot be a parameter's name")
    return tuple(dict.fromkeys(node.name for node in found if node.name not in _VARIABLES))


def _from_functions(
    name: str,
    force: str | Callable[..., float],
    friction: str | Callable[..., float],
    rates: tuple[Node, ...],
    listed: tuple[str, ...],
) -> _Draft:
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

    return _Draft(
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


def _finished(
    draft: _Draft,
    listed: tuple[Parameter, ...],
    starts: dict[str, tuple[float, ...]],
    *,
    title: str = "",
    tell: str = "",
    proof: str = "",
) -> Effect:
    parameters = _parameters(draft, listed, starts)
    draw = _draw_of(parameters, starts)
    check_values(draft.name, draft.values, draw)
    _check_together(draft, draw)
    states = len(draft.rates)
    rates = None
    if states:
        padded = (*draft.rates, *[ZERO] * (STATES - states))
        rates = rate_function(python_function(padded, draft.names), cache=False)
    settles = bool(states) and comes_to_rest(draft.rates, draw)
    return Effect(
        name=draft.name,
        title=title or f"{draft.name} (your own)",
        kind="physics",
        equation=draft.equation,
        parameters=parameters,
        tell=tell or "what your formula says",
        proof=proof or "a recording in which your formula predicts a large change",
        force=_nothing if draft.force is None else _compiled(draft.force),
        friction=None if draft.friction is None else _compiled(draft.friction),
        rates=rates,
        rest=(rest_function(rates, states) if settles else lambda u, p: (0.0, 0.0)) if states else None,
        states=states,
        forgets=settles or not states,
        starts=_starts_function(parameters[1:], starts, _even(draft, draw)),
        kinked=True,
    )


def _compiled(function: Any) -> Any:
    return function if hasattr(function, "signatures") else force_function(function, cache=False)


def _parameters(
    draft: _Draft, listed: tuple[Parameter, ...], starts: dict[str, tuple[float, ...]]
) -> tuple[Parameter, ...]:
    given = {p.name: p for p in listed}
    for called in (*given, *starts):
        if called not in draft.names:
            raise ValueError(
                f"{draft.name}: {called} is no parameter of the formula; {', '.join(draft.names)} are"
            )
    for p in listed:
        if not p.low < p.high:
            raise ValueError(f"{draft.name}: {p.name} cannot lie between {p.low:g} and {p.high:g}")
        if p.unit:
            try:
                dimensions_of(p.unit)
            except ValueError as error:
                raise ValueError(f"{draft.name}: {p.name}: {error}") from error
    for called, values in starts.items():
        low, high = (given[called].low, given[called].high) if called in given else (-inf, inf)
        for value in values:
            if not isfinite(value) or not low <= value <= high:
                raise ValueError(f"{draft.name}: {called} cannot start at {value:g}, outside its bounds")
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


def _check_together(draft: _Draft, draw: Draw) -> None:
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
        f"{draft.name}: {', '.join(together)} act only together, so that no record can tell them apart; leave one out"
    )


def _even(draft: _Draft, draw: Draw) -> frozenset[str]:
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


def _starts_function(
    inner: tuple[Parameter, ...], starts: dict[str, tuple[float, ...]], even: frozenset[str]
) -> Callable[[Scales], tuple[tuple[float, ...], ...]]:
    def of(scales: Scales) -> tuple[tuple[float, ...], ...]:
        return combinations(
            [starts_of(p, starts.get(p.name, ()), scales, even=p.name in even) for p in inner]
        )

    return of
