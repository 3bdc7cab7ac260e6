"""The verdict: what may be said of a model, in a word, a headline and with what goes with it."""

from dataclasses import dataclass
from typing import Literal

from identify.curves.confirmation import Confirmation
from identify.diagnosis.nonparametric_force import NonparametricForce
from identify.diagnosis.suspects import Candidate
from identify.fitting.fit import Fit
from identify.fitting.random_walk import RandomWalk

Verdict = Literal[
    "missing_effect",
    "sensor_fault",
    "nothing_missing",
    "unknown_effect",
    "unconfirmed",
    "driven",
    "not_enough_data",
]

HEADLINES: dict[Verdict, str] = {
    "missing_effect": "A force is missing",
    "sensor_fault": "A sensor is at fault",
    "nothing_missing": "Nothing is missing",
    "unknown_effect": "Something is missing that has no name here",
    "unconfirmed": "No known effect predicts the residual",
    "driven": "The motion is driven",
    "not_enough_data": "Not enough data",
}


@dataclass(frozen=True, eq=False)
class Judgement:
    """The verdict on a model, and what goes with it.

    `ranked` are the candidates, what the verdict names first; `together` the other effects where it takes several; `final`
    the fit with what was found; `shape` the free form, when something is missing that has no name. `confirmation` is what
    curves predict, None where they were not asked. `too_small` is what was removed, in % of the motion, by what is sure and
    too small to be named; 0 where that is not so. `walk` is what a random walk of spring and damper explains, where a name
    is not told from it, or where it is what is left beside a name; None elsewhere.
    """

    verdict: Verdict
    ranked: tuple[Candidate, ...]
    final: Fit
    together: tuple[str, ...] = ()
    shape: NonparametricForce | None = None
    confirmation: Confirmation | None = None
    too_small: float = 0.0
    walk: RandomWalk | None = None


def verdict_of(candidate: Candidate) -> Verdict:
    """Return what is said where one candidate is named."""
    return "missing_effect" if candidate.term.effect.kind == "physics" else "sensor_fault"
