"""A user's own effect: a formula on the command line, or formulas in a Python file.

Behind a formula's semicolons stand unit, bounds and starting values of its parameters:

```text
setting = parameter [":" unit] [bounds] ["start" value {"," value}]
bounds  = "=" low ".." high  or  [">=" low] ["<=" high]
```
"""

import ast
import re
from dataclasses import dataclass
from math import inf, isfinite

from identify.effects.compiled import STATES
from identify.effects.effect import Parameter
from identify.effects.force_effect import ForceEffect
from identify.effects.library import NAMED
from identify.effects.user.build import NAME, VARIABLES, finished, from_formulas
from identify.effects.user.formula import CONSTANTS, FUNCTIONS, parse_formula
from identify.effects.user.initial_values import problem_of
from identify.effects.user.measured_curve import curve_effect, read_curve

_LONGEST_LINE = 1000
_PARAMETER = r"[A-Za-z](?a:\w*)"
_NUMBER = r"[-+]?(?:\d+(?:\.\d+)?|\.\d+)(?:[eE][-+]?\d{1,3})?"
_UNIT = r"[^=<>;:,]*?(?=\s*(?:>=|<=|=|\bstart\b|$))"
_LIKE = "such as 'b: m >= 0 start 0.002, 0.01' or 'b: m = 0..0.05'"


def parse_effect(text: str) -> ForceEffect:
    """Return the effect that a line describes, such as `magnet = a*u/(1 + (u/b)**2); b: m >= 0 start 0.002, 0.01`.

    Left of the sign stands the name, right of it the force per unit mass in t (s since the release), u, v and parameters
    of your own; what multiplies `sgn(v)` is dry friction. After semicolons a parameter may have a unit, bounds and
    starting values, as the head of this module says. `spline(u, -0.02, 0.02, 4)` is a measured
    curve (`measured_curve`). Raises ValueError, in a sentence with the place, when it cannot be read.
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
    curve = read_curve(formula)
    if curve is not None and not rest:
        return curve_effect(name, curve)
    settings: list[_Setting] = []
    before = len(first) + 1
    for part in rest:
        if part.strip():
            settings.append(_read_setting(part.rstrip(), before=before))
        before += len(part) + 1
    draft = from_formulas(name, parse_formula(formula, before=len(left) + 1), (), formula.strip())
    for i, setting in enumerate(settings):
        called = setting.parameter.name
        if called not in draft.names:
            raise ValueError(f"character {setting.at}: {called} does not stand in the formula of {name}")
        if called in (earlier.parameter.name for earlier in settings[:i]):
            raise ValueError(f"character {setting.at}: {called} is set twice")
    return finished(
        draft,
        tuple(setting.parameter for setting in settings),
        {setting.parameter.name: setting.starts for setting in settings if setting.starts},
    )


def own_effect(
    name: str,
    force: str,
    *,
    rates: tuple[str, ...] = (),
    parameters: tuple[Parameter, ...] = (),
    starts: dict[str, tuple[float, ...]] | None = None,
) -> ForceEffect:
    """Return an effect of the user's own.

    `force` is a formula in t, u, v, z0, z1 and parameters, in which what multiplies `sgn(v)` is dry friction; `rates` are
    formulas of the rates of up to two internal states z0 and z1. `parameters` gives units, meanings and bounds,
    `starts` starting values of inner parameters. The force must be proportional to one parameter; a formula that
    is to none has one called `scale` put before it. Raises ValueError, in a sentence, when it cannot be used.
    """
    _check_name(name)
    if len(rates) > STATES:
        raise ValueError(f"{name}: at most {STATES} internal states, not {len(rates)}")
    changes = tuple(_parsed(name, f"rate {i + 1}", rate) for i, rate in enumerate(rates))
    draft = from_formulas(name, _parsed(name, "force", force), changes, str(force).strip())
    return finished(draft, parameters, starts or {})


def _check_name(name: str) -> None:
    if not NAME.fullmatch(name):
        raise ValueError(
            f"'{name[:40]}' cannot be an effect's name; write letters, digits and _, a letter first"
        )
    if name in FUNCTIONS or name in VARIABLES or name in CONSTANTS:
        raise ValueError(f"'{name}' has a meaning in formulas; choose another name for the effect")
    if any(effect.name == name for effect in NAMED):
        raise ValueError(
            f"{name} is in the library already; choose another name, or add it without a formula"
        )


def _parsed(name: str, what: str, text: object) -> ast.expr:
    if not isinstance(text, str):
        raise ValueError(f"{name}: the {what} must be a formula, not {type(text).__name__}")
    try:
        return parse_formula(text)
    except ValueError as error:
        raise ValueError(f"{name}: {what}, {error}") from error


@dataclass(frozen=True)
class _Setting:
    """A parameter as the user describes it, and where a fit may begin; `at` is its place in the text, from 1."""

    parameter: Parameter
    starts: tuple[float, ...]
    at: int


class _Reader:
    """Reads one setting from left to right; `before` characters of what the user typed stand before it."""

    def __init__(self, text: str, before: int) -> None:
        self.text, self.before, self.at = text, before, len(text) - len(text.lstrip())

    @property
    def place(self) -> int:
        return self.before + self.at + 1

    def take(self, pattern: str) -> str | None:
        found = re.compile(rf"({pattern})\s*").match(self.text, self.at)
        self.at = found.end() if found else self.at
        return found[1] if found else None

    def read(self, pattern: str, what: str) -> str:
        found = self.take(pattern)
        if found is None:
            raise ValueError(f"character {self.place}: {what} is expected here, {_LIKE}")
        return found

    def number(self) -> float:
        place, value = self.place, float(self.read(_NUMBER, "a number"))
        if not isfinite(value):
            raise ValueError(f"character {place}: this number is too large")
        return value


def _read_setting(text: str, *, before: int) -> _Setting:
    """Read a setting; ValueError, in a sentence with the place, when it cannot be read."""
    reader = _Reader(text, before)
    at = {"name": reader.place}
    name = reader.read(_PARAMETER, "a parameter")
    has_unit = reader.take(":")
    at["unit"] = reader.place
    unit = reader.read(_UNIT, "a unit").strip() if has_unit else ""
    if has_unit and not unit:
        raise ValueError(f"character {at['unit']}: a unit is expected here, {_LIKE}")
    at["bounds"] = reader.place
    parameter = Parameter(name, unit, "", *_bounds(reader))
    starts: tuple[float, ...] = ()
    if reader.take("start"):
        at["start"] = reader.place
        starts = (reader.number(),)
        while reader.take(","):
            starts = (*starts, reader.number())
    problem = problem_of(parameter, starts)
    if problem is not None:
        raise ValueError(f"character {at[problem[0]]}: {problem[1]}")
    if reader.at < len(text):
        raise ValueError(
            f"character {reader.place}: '{text[reader.at :][:20].strip()}' is not understood, {_LIKE}"
        )
    return _Setting(parameter, starts, at["name"])


def _bounds(reader: _Reader) -> tuple[float, float]:
    if reader.take("="):
        low = reader.number()
        reader.read(r"\.\.", "'..' with the upper bound")
        return low, reader.number()
    low = reader.number() if reader.take(">=") else -inf
    high = reader.number() if reader.take("<=") else inf
    return low, high
