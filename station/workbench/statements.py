"""What the page says of each model beside its picture: how much it leaves, and what a suspect would explain."""

from typing import Any

from identify.formatting import plain_name
from station.results.ladder import KeptLadder, KeptStep
from station.story.residual import explained_words, times
from station.text.diagnosis_text import parameters
from station.text.numbers import three_figures
from station.workbench import view_models
from station.workbench.ladder_bars import share


def says_of(view: view_models.View, summary: str) -> dict[str, dict[str, Any]]:
    """Write the words of each step, as "step0", and of each suspect, by its effect.

    `summary` tells where the present model fails, as soon as that is known.
    """
    found: dict[str, dict[str, Any]] = {}
    for place, step in enumerate(view.ladder.steps):
        found[f"step{place}"] = _step(view, place, step, summary)
    if view.diagnosis is not None:
        for suspect in view.diagnosis.suspects:
            name, values = plain_name(suspect.effect), parameters(suspect)
            told = with_effect(view.ladder, name, suspect.motion_percent, suspect.error_after, values)
            found[suspect.effect] = told
    return found


def _step(view: view_models.View, place: int, step: KeptStep, summary: str) -> dict[str, Any]:
    error, floor = step.error, step.at_floor
    present = place == view.ladder.present
    name = f"the {step.name}" if present else f"step {place}"
    what = f"of the motion: residual of {name}, {times(error.chi2)} times the noise"
    more = " + ".join(plain_name(name) for name in step.effects)
    if present and floor:
        more = f"Only noise remains. {more}"
    elif present and summary:
        more = summary
    called = step.began if place == 0 else f"with {plain_name(step.added)}" if step.added else name
    return {
        "big": f"{three_figures(error.motion_percent)} %",
        "what": what,
        "more": more,
        "short": f"{called}: {times(error.chi2)} × noise",
        "floor": floor,
    }


def with_effect(
    ladder: KeptLadder, called: str, motion: float | None, chi2: float | None, more: str
) -> dict[str, Any]:
    """Say what the present model leaves with one more effect, what that explains, and `more`."""
    words = explained_words(ladder.top.error.chi2, chi2, ladder.top.chi2_std)
    return {
        "big": f"{three_figures(motion)} %",
        "what": f"of the motion with {called}: {times(chi2)} times the noise",
        "words": words,
        "more": f"It {words}. {more}" if words else more,
        "short": f"with {called}: {times(chi2)} × noise",
        "times": times(chi2),
        "share": round(share(chi2, ladder)[0], 1),
        "floor": False,
    }
