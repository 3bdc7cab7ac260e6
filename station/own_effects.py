"""The user's own effects from a Python file. The file is code: it is read only when the user names it."""

import runpy
import traceback
from pathlib import Path

from identify.effects.effect import Effect


def load_effects(path: Path) -> tuple[Effect, ...]:
    """Run a Python file and return the effects in its `EFFECTS`; ValueError, with the line, when it has none.

    Raises OSError when the file cannot be read.
    """
    path.read_bytes()
    try:
        found = runpy.run_path(str(path)).get("EFFECTS")
    except (Exception, SystemExit) as error:
        lines = [
            frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)
        ]
        line = error.lineno if isinstance(error, SyntaxError) else lines[-1] if lines else None
        where = f"{path}, line {line}" if line else str(path)
        raise ValueError(f"{where}: {type(error).__name__}: {error}") from error
    effects = tuple(found) if isinstance(found, tuple | list) else ()
    if not effects or not all(isinstance(effect, Effect) for effect in effects):
        raise ValueError(f"{path}: it must define EFFECTS = (own_effect(...), ...), a tuple of effects")
    return effects
