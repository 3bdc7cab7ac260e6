"""Settings of a user's own effect as they stand after a semicolon: unit, bounds and starting values of a parameter.

```text
setting = parameter [":" unit] [bounds] ["start" value {"," value}]
bounds  = "=" low ".." high  or  [">=" low] ["<=" high]
```
"""

import re
from dataclasses import dataclass
from math import inf, isfinite

from identify.effects.effect import Parameter
from identify.effects.user.initial_values import problem_of

_NAME = r"[A-Za-z](?a:\w*)"
_NUMBER = r"[-+]?(?:\d+(?:\.\d+)?|\.\d+)(?:[eE][-+]?\d{1,3})?"
_UNIT = r"[^=<>;:,]*?(?=\s*(?:>=|<=|=|\bstart\b|$))"
_LIKE = "such as 'b: m >= 0 start 0.002, 0.01' or 'b: m = 0..0.05'"


@dataclass(frozen=True)
class OwnSetting:
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


def read_setting(text: str, *, before: int) -> OwnSetting:
    """Read a setting; ValueError, in a sentence with the place, when it cannot be read."""
    reader = _Reader(text, before)
    at = {"name": reader.place}
    name = reader.read(_NAME, "a parameter")
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
    return OwnSetting(parameter, starts, at["name"])


def _bounds(reader: _Reader) -> tuple[float, float]:
    if reader.take("="):
        low = reader.number()
        reader.read(r"\.\.", "'..' with the upper bound")
        return low, reader.number()
    low = reader.number() if reader.take(">=") else -inf
    high = reader.number() if reader.take("<=") else inf
    return low, high
