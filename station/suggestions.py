"""Suggestions for a mistyped word."""

import difflib
import re
from collections.abc import Iterable
from importlib.resources import files

from station.exits import UsageProblem

MEASURED_CURVE = "measured_curve"
"""What is added to a model where no effect of the library fits: the measured curve of the residual."""

_CLOSE = 0.6
_MOST = 3
_SHORTEST = 4
_OF_A_PART = 0.9


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return "; did you mean 'stribeck_friction'?" for a mistyped word, with the nearest names first; "" without any."""
    lower = word.lower().strip()
    scored = sorted(
        ((_likeness(lower, name.lower()), name) for name in dict.fromkeys(known)), key=lambda x: -x[0]
    )
    found = [name for likeness, name in scored if likeness >= _CLOSE][:_MOST]
    if not found:
        return ""
    quoted = [f"'{name}'" for name in found]
    return f"; did you mean {' or '.join(quoted)}?"


def no_such_effect(name: str, known: Iterable[str]) -> UsageProblem:
    """Return the refusal of an effect that is none, with what may have been meant."""
    more = 'see `station effects`, or write one as "magnet = a*u/(1+(u/b)**2)"'
    return UsageProblem(f"no effect is called '{name}'{did_you_mean(name, known)}; {more}")


def _likeness(word: str, name: str) -> float:
    """Say how like a name a word is, 0 to 1: the whole of it, or one of its parts."""
    parts = [part for part in re.split(r"[_\W]+", name) if len(part) >= _SHORTEST]
    whole = difflib.SequenceMatcher(None, word, name).ratio()
    return max([whole, *(_OF_A_PART * difflib.SequenceMatcher(None, word, part).ratio() for part in parts)])


def effect_names() -> tuple[str, ...]:
    """Return the names of the library's effects, read from its source, so that nothing has to be compiled for a typo."""
    found: list[str] = []
    for file in files("identify.effects").iterdir():
        if file.name.endswith(".py") and file.name != "families.py":
            found += re.findall(r'^    name="(\w+)",$', file.read_text(encoding="utf-8"), re.MULTILINE)
    return tuple(sorted(found))
