"""What the page says of each model beside its picture: how much it leaves, and what a suspect would explain."""

import math
from typing import Any

from station.results.diagnosis_document import SuspectDocument
from station.results.ladder import KeptRung
from station.text.diagnosis_text import STRENGTH_UNKNOWN
from station.text.numbers import three_figures, typeset, with_unit
from station.workbench import view_models
from station.workbench.explained import explained_words
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
    error, floor = rung.error, view_models.reaches_floor(rung)
    present = place == view.ladder.present
    if floor:
        what = "Nothing but noise is left"
    else:
        what = (
            "times what noise explains is left: the model fails here"
            if present
            else "times what noise explains is left"
        )
    more = _shares(error.motion_percent, error.force_mse_percent)
    if present and not floor:
        more = f"{summary}{_shares(error.motion_percent, None)}"
    if not present:
        more = f"Rung {place}: {' + '.join(plain(name) for name in rung.effects)}. {more}"
    return {"big": f"{three_figures(error.chi2)} ×", "what": what, "more": more, "floor": floor}


def _shares(motion: float | None, force: float | None) -> str:
    parts = []
    if motion is not None:
        parts.append(f"{three_figures(motion)} % of the motion")
    if force is not None:
        parts.append(f"{three_figures(force)} % of the force (mean square)")
    return f"Left over: {' and '.join(parts)}." if parts else ""


def _suspect(view: view_models.View, suspect: SuspectDocument) -> dict[str, Any]:
    before, after = view.ladder.top.error.chi2, suspect.error_after
    values = ", ".join(f"{name} = {typeset(with_unit(value))}" for name, value in suspect.parameters.items())
    values = values if suspect.strength_known else f"{STRENGTH_UNKNOWN.capitalize()}."
    filled, _ = share(after, view.ladder)
    return {
        "big": f"{three_figures(after)} ×",
        "what": f"with {plain(suspect.effect)}: {explained_words(before, after, view.ladder.top.chi2_std)}",
        "more": f"{_shares(suspect.motion_percent, None)} {values}".strip(),
        "chi2": three_figures(after),
        "share": round(filled, 1) if after is not None and math.isfinite(after) else 100.0,
        "floor": False,
    }
