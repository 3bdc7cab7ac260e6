"""What a mistyped word may have meant."""

import difflib
import re
from collections.abc import Iterable
from importlib.resources import files

MEASURED_CURVE = "measured_curve"
"""What is added to a model where no effect of the library fits: the measured curve of what is left."""

_CLOSE = 0.6
_MOST = 3


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return "; did you mean 'stribeck_friction'?" for a mistyped word, with the nearest names first; "" without any."""
    names = list(dict.fromkeys(known))
    lower = word.lower().strip()
    near = [name for name in names if lower and lower in name.lower()]
    near += difflib.get_close_matches(lower, names, _MOST, _CLOSE)
    near += [name for name in names if any(_alike(lower, part) for part in re.split(r"[_\W]+", name))]
    found = list(dict.fromkeys(near))[:_MOST]
    if not found:
        return ""
    quoted = [f"'{name}'" for name in found]
    return f"; did you mean {' or '.join(quoted)}?"


def _alike(word: str, part: str) -> bool:
    return len(part) > 3 and difflib.SequenceMatcher(None, word, part).ratio() > 0.75


def effect_names() -> tuple[str, ...]:
    """Return the names of the library's effects, read from its source, so that nothing has to be compiled for a typo."""
    found: list[str] = []
    for file in files("identify.effects").iterdir():
        if file.name.endswith(".py") and file.name != "families.py":
            found += re.findall(r'^    name="(\w+)",$', file.read_text(encoding="utf-8"), re.MULTILINE)
    return tuple(sorted(found))
