"""From a comparison to what the page draws: units that people read, and digits that the eye can see."""

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from identify.effects.library import LIBRARY
from station.results import diagnosis_document
from station.results.ladder import LADDER, KeptLadder
from station.results.models import parsed_effect
from station.text.numbers import typeset
from station.workbench import view_models

MOST_POINTS = 3000
EYE = 2000

Array = NDArray[np.float64]


def numbers(values: Array, quantum: float) -> view_models.Numbers:
    """Return values rounded to a decimal place below `quantum`, None where they are not finite."""
    places = 0 if quantum <= 0 or not math.isfinite(quantum) else max(0, -math.floor(math.log10(quantum)))
    return [round(value, places) if math.isfinite(value) else None for value in values.tolist()]


def for_eye(values: Array) -> view_models.Numbers:
    """Return values rounded to what can be seen on a screen: a few thousandths of the largest."""
    finite = values[np.isfinite(values)]
    return numbers(values, float(np.max(np.abs(finite), initial=0.0)) / EYE)


def equations_of(ladder: KeptLadder) -> dict[str, str]:
    """Return the equations of the effects of the library, and of the user's own in the ladder, by the effect's name."""
    own = dict.fromkeys(text for step in ladder.steps for text in step.model.expressions)
    effects = (*LIBRARY, *(parsed_effect(text) for text in own))
    return {effect.name: typeset(effect.equation) for effect in effects}


def results_stamp(folder: Path) -> tuple[int, ...]:
    """Read a stamp that changes when a command, or another tab, has written results."""
    stamp = []
    for name in (LADDER, diagnosis_document.NAME):
        try:
            stamp.append((folder / "results" / name).stat().st_mtime_ns)
        except OSError:
            stamp.append(0)
    return tuple(stamp)
