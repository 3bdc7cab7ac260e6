"""What the page says of each model beside its picture: how much it leaves, and what a suspect would explain."""

import math
from typing import Any

from station.results.diagnosis_document import SuspectDocument
from station.results.ladder import KeptRung
from station.story.residual import explained_words, times
from station.text.diagnosis_text import STRENGTH_UNKNOWN
from station.text.numbers import three_figures, typeset, with_unit
from station.workbench import view_models
from station.workbench.ladder_bars import share
from station.workbench.names import plain


def says_of(view: view_models.View, details: view_models.Details | None = None) -> dict[str, dict[str, Any]]:
    """Return the words of each rung, as "rung0", and of each suspect, by its effect.

    `details` tell where the present model fails, as soon as they are known.
    """
    summary = f"{details.picture.summary} " if details is not None else ""
    found: dict[str, dict[str, Any]] = {}
    for place, rung in enumerate(view.ladder.rungs):
        found[f"rung{place}"] = _rung(view, place, rung, summary)
    if view.diagnosis is not None:
        for suspect in view.diagnosis.suspects:
            found[suspect.effect] = _suspect(view, suspect)
    return found


def _rung(view: view_models.View, place: int, rung: KeptRung, summary: str) -> dict[str, Any]:
    error, floor = rung.error, rung.at_floor
    present = place == view.ladder.present
    name = f"the {rung.name}" if present else f"rung {place}"
    what = f"of the motion: residual of {name}, {times(error.chi2)} times the noise"
    more = " + ".join(plain(name) for name in rung.effects)
    if present and floor:
        more = f"Nothing but noise is left. {more}"
    elif present and summary:
        more = summary
    return {"big": _percent(error.motion_percent), "what": what, "more": more, "floor": floor}


def _percent(motion: float | None) -> str:
    return f"{three_figures(motion)} %"


def _suspect(view: view_models.View, suspect: SuspectDocument) -> dict[str, Any]:
    before, after = view.ladder.top.error.chi2, suspect.error_after
    values = ", ".join(f"{name} = {typeset(with_unit(value))}" for name, value in suspect.parameters.items())
    values = values if suspect.strength_known else f"{STRENGTH_UNKNOWN.capitalize()}."
    filled, _ = share(after, view.ladder)
    return {
        "big": _percent(suspect.motion_percent),
        "what": f"of the motion with {plain(suspect.effect)}, {times(after)} times the noise: "
        f"{explained_words(before, after, view.ladder.top.chi2_std)}",
        "more": values,
        "times": times(after),
        "share": round(filled, 1) if after is not None and math.isfinite(after) else 100.0,
        "floor": False,
    }
