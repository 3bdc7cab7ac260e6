"""The user's own effects from a Python file. The file is code: it is read only when the user names it."""

import runpy
import traceback
from pathlib import Path

from identify.effects.effect import Effect
from identify.effects.library import LIBRARY, NAMED, find_effect
from station.exits import UsageProblem
from station.suggestions import MEASURED_CURVE, did_you_mean, read_named

_EXAMPLE = 'EFFECTS = (own_effect("magnet", "a*u/(1 + (u/b)**2)"),)'


def whole_library(file: Path | None) -> tuple[Effect, ...]:
    """Return the library with the user's own effects from a Python file after it."""
    return LIBRARY if file is None else (*LIBRARY, *load_effects(file))


def named_effect(name: str, library: tuple[Effect, ...] = LIBRARY) -> Effect:
    """Return the effect of that name; UsageProblem, with what may have been meant, where there is none."""
    try:
        return find_effect(name, library)
    except KeyError as error:
        meant = did_you_mean(name, (*(effect.name for effect in (*NAMED, *library)), MEASURED_CURVE))
        more = 'see `station effects`, or write one as "magnet = a*u/(1+(u/b)**2)"'
        raise UsageProblem(f"no effect is called '{name}'{meant}; {more}") from error


def load_effects(path: Path) -> tuple[Effect, ...]:
    """Run a Python file and return the effects in its `EFFECTS`; UsageProblem, with the line, where it has none."""
    read_named(path, "the effects")
    try:
        found = runpy.run_path(str(path)).get("EFFECTS")
    except (Exception, SystemExit) as error:
        raise UsageProblem(f"{_place(path, error)}: {_reason(error)}") from error
    if isinstance(found, Effect):
        found = (found,)
    if not isinstance(found, tuple | list) or not found:
        raise UsageProblem(f"{path}: it defines no effects; a line such as {_EXAMPLE} is missing")
    names = [effect.name for effect in NAMED]
    for i, effect in enumerate(found, start=1):
        if not isinstance(effect, Effect):
            raise UsageProblem(
                f"{path}: entry {i} of EFFECTS is {type(effect).__name__}; give own_effect(...)"
            )
        if effect.name in names:
            raise UsageProblem(f"{path}: another effect is called {effect.name} too; rename this one")
        names.append(effect.name)
    return tuple(found)


def _place(path: Path, error: BaseException) -> str:
    lines = [f.lineno for f in traceback.extract_tb(error.__traceback__) if f.filename == str(path)]
    line = error.lineno if isinstance(error, SyntaxError) and not lines else lines[-1] if lines else None
    return f"{path}, line {line}" if line else str(path)


def _reason(error: BaseException) -> str:
    if isinstance(error, SystemExit):
        return "it ends the program; a file of effects only defines them"
    text = error.msg if isinstance(error, SyntaxError) else str(error)
    first = text.strip().splitlines()[0] if text.strip() else ""
    known = isinstance(error, ValueError) and first
    return first if known else f"{type(error).__name__}: {first}" if first else type(error).__name__
