"""The verdict on a model: a word, a headline, and the judgement with all that belongs to it."""

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
    """The verdict on a model, with its candidates and fits.

    `ranked` are the candidates, what the verdict names first; `together` the other effects where it takes several; `final`
    the fit with what was found; `shape` the free-form force, when the missing force has no name. `confirmation` is what
    curves predict, None where they were not asked. `too_small` is what was removed, in % of the motion, by what is sure and
    too small to be named; 0 where that is not so. `walk` is a random walk of spring and damper that is not distinguishable
    from the name, or remains beside it; else None.
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
    """Choose the verdict for one named candidate: a force or a sensor's fault."""
    return "missing_effect" if candidate.term.effect.kind == "physics" else "sensor_fault"
