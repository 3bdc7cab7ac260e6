"""The user's own effects from a Python file. The file is code: it is read only when the user names it."""

import runpy
import traceback
from pathlib import Path

from identify.effects.effect import Effect

_EXAMPLE = 'EFFECTS = (own_effect("magnet", "a*u/(1 + (u/b)**2)"),)'


def load_effects(path: Path) -> tuple[Effect, ...]:
    """Run a Python file and return the effects in its `EFFECTS`; ValueError, a sentence with the line, when it has none.

    Raises OSError when the file cannot be read.
    """
    path.read_bytes()
    try:
        found = runpy.run_path(str(path)).get("EFFECTS")
    except (Exception, SystemExit) as error:
        raise ValueError(f"{_place(path, error)}: {_reason(error)}") from error
    if isinstance(found, Effect):
        found = (found,)
    if not isinstance(found, tuple | list) or not found:
        raise ValueError(f"{path}: it defines no effects; a line such as {_EXAMPLE} is missing")
    for i, effect in enumerate(found):
        if not isinstance(effect, Effect):
            raise ValueError(
                f"{path}: entry {i + 1} of EFFECTS is {type(effect).__name__}; give own_effect(...)"
            )
    names = [effect.name for effect in found]
    for i, name in enumerate(names):
        if name in names[:i]:
            raise ValueError(f"{path}: two effects are called {name}; rename one")
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
