"""The statements beside a model's picture: its residual, and how much of it a suspect would explain."""

import math

from identify.formatting import plain_name, three_figures
from identify.residual import explained_words, times
from station.results.diagnosis_document import DiagnosisDocument, SuspectDocument
from station.results.ladder import KeptLadder, KeptStep
from station.results.models import name_of
from station.suggestions import MEASURED_CURVE
from station.text.diagnosis_text import parameters
from station.workbench.view_models import Drawing, View

LEAST = 0.5
"""Reduced chi-square at which the bars of the ladder begin, so that a model at the floor still has one."""


def share(chi_square: float | None, ladder: KeptLadder) -> float:
    """Place a reduced chi-square on the logarithmic track of the ladder's bars, in %; all of it where it is not known."""
    largest = max([step.error.chi2 or 1.0 for step in ladder.steps] + [2.0])
    value = largest if chi_square is None else chi_square
    place = math.log(max(value, LEAST) / LEAST) / math.log(largest / LEAST)
    return round(100.0 * min(1.0, place), 1)


def called(wanted: str) -> str:
    """Name what is added to a model: an effect, an expression, or the measured curve."""
    return "the measured curve" if wanted == MEASURED_CURVE else plain_name(name_of(wanted))


def switched_off(ladder: KeptLadder) -> list[tuple[str, str]]:
    """List the effects that stood in the model on the way to the present step, and do not now, with what adds each again."""
    before = dict.fromkeys(name for step in ladder.steps[: ladder.present] for name in step.effects)
    own = {name_of(text): text for step in reversed(ladder.steps) for text in step.model.expressions}
    return [(name, own.get(name, name)) for name in before if name not in ladder.top.effects]


def says_of(view: View, summary: str) -> dict[str, Drawing]:
    """Write the words of each step, as "step0", and of each suspect, by its effect.

    `summary` tells where the present model fails, as soon as that is known.
    """
    found = {
        f"step{place}": _step(view, place, step, summary) for place, step in enumerate(view.ladder.steps)
    }
    document = view.diagnosis
    if document is None:
        return found
    many = len(document.sessions)
    for suspect in document.suspects:
        found[suspect.effect] = with_effect(
            view.ladder,
            plain_name(suspect.effect),
            suspect.motion_percent,
            suspect.error_after,
            explains(document, suspect),
            parameters(suspect, view.weighing).replace("in the ", "In the ", 1),
            f"{many} releases together" if many > 1 else "",
        )
    return found


def explains(document: DiagnosisDocument, suspect: SuspectDocument) -> str:
    """Say how much a suspect would explain of what the model leaves in all releases that were diagnosed."""
    return explained_words(document.error.chi2, suspect.error_after, document.error.chi2_std)


def _step(view: View, place: int, step: KeptStep, summary: str) -> Drawing:
    error, present = step.error, place == view.ladder.present
    name = f"the {step.name}" if present else f"step {place}"
    more = " + ".join(plain_name(name) for name in step.effects)
    if present and step.at_floor:
        more = f"Only noise remains. {more}"
    elif present and summary:
        more = summary
    called = step.began if place == 0 else f"with {plain_name(step.added)}" if step.added else name
    return {
        "big": f"{three_figures(error.motion_percent)} %",
        "what": f"of the motion: residual of {name}, {times(error.chi2)} times the noise",
        "more": more,
        "short": f"{called}: {times(error.chi2)} × noise",
        "floor": step.at_floor,
    }


def with_effect(
    ladder: KeptLadder,
    called: str,
    motion: float | None,
    chi2: float | None,
    words: str,
    more: str,
    whose: str = "",
) -> Drawing:
    """Say what the present model leaves with one more effect, in `words` what that explains, and `more`.

    `whose` says of which releases, where these are not the page's own alone: its ladder has no such step then.
    """
    return {
        "big": f"{three_figures(motion)} %",
        "what": f"of the motion{f', {whose}' if whose else f' with {called}'}: {times(chi2)} times the noise",
        "words": words,
        "more": f"It {words}. {more}" if words else more,
        "short": f"{f'{called}, together' if whose else f'with {called}'}: {times(chi2)} × noise",
        "times": "" if whose else times(chi2),
        "share": 0.0 if whose else share(chi2, ladder),
        "floor": False,
    }
