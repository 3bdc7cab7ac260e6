"""The verdict on a model: a word, a headline, the judgement with all that belongs to it, and when data are too few."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from identify.curves.confirmation import Confirmation
from identify.curves.decay_curve import DecayCurve
from identify.effects.effect import Kind
from identify.evidence import Evidence
from identify.fitting.baseline import Baseline
from identify.fitting.fit import Fit
from identify.fitting.model_error import motion_percent
from identify.fitting.random_walk import RandomWalk
from identify.formatting import among, plain_name, three_figures
from identify.judging.nonparametric_force import NonparametricForce
from identify.judging.suspects import Candidate, InPlace
from identify.priors import FEWEST_CYCLES

Verdict = Literal[
    "missing_effect",
    "sensor_fault",
    "nothing_missing",
    "unknown_effect",
    "unconfirmed",
    "driven",
    "not_enough_data",
]

MOST_RIVALS = 2
"""Rivals that are named, listed or drawn beside a name."""

HEADLINES: dict[Verdict, str] = {
    "missing_effect": "A force is missing",
    "sensor_fault": "A sensor is at fault",
    "nothing_missing": "Nothing is missing",
    "unknown_effect": "Something is missing, and no effect can be named",
    "unconfirmed": "No known effect predicts the residual",
    "driven": "The motion is driven",
    "not_enough_data": "Not enough data",
}


def headline_of(
    verdict: Verdict,
    named: Sequence[str] = (),
    rivals: Sequence[str] = (),
    kinds: Mapping[str, Kind] | None = None,
    *,
    undecided: bool = False,
) -> str:
    """Write a verdict in one line, a single name with what is plausible and not distinguishable from it, its `rivals`.

    `kinds` are those of the plausible suspects, by name; `undecided` says that curves show effects of which none is sure
    enough for a name.
    """
    known = kinds or {}
    alike = [rival for rival in rivals if rival in known] if len(named) == 1 else []
    words = HEADLINES[verdict]
    if verdict == "unconfirmed" and undecided:
        words = "Something is missing, and no effect is sure enough for a name"
    if len({known[name] for name in (*named[:1], *alike) if name in known}) > 1:
        words = "A force is missing, or a sensor is at fault"
    if not named:
        return words
    if len(alike) > MOST_RIVALS:
        return f"{words}: {plain_name(named[0])}, or one of {len(alike)} others"
    return f"{words}: {among([plain_name(name) for name in (*named, *alike)], 'or' if alike else 'and')}"


@dataclass(frozen=True, eq=False)
class Judgement:
    """The verdict on a model, with its candidates and fits.

    `ranked` are the candidates, what the verdict names first; `together` the other effects where it takes several; `final`
    the fit with what was found; `shape` the free-form force, when the missing force has no name. `confirmation` is what
    curves predict, None where they were not asked; `driven` the curve of a motion that does not die away. `too_small` is
    what was removed, in % of the motion, by what is sure and too small to be named; 0 where that is not so. `walk` is a
    random walk of spring and damper that remains beside the name or, without one, explains all of the misfit; else None.
    `decided` is what the table weighed and decided, for each of several effects its own, and `places` are what was tried in
    the place of each of these.
    """

    verdict: Verdict
    ranked: tuple[Candidate, ...]
    final: Fit
    together: tuple[str, ...] = ()
    shape: NonparametricForce | None = None
    confirmation: Confirmation | None = None
    driven: DecayCurve | None = None
    too_small: float = 0.0
    walk: RandomWalk | None = None
    decided: tuple[Evidence, ...] = ()
    places: tuple[InPlace, ...] = ()

    @property
    def stands(self) -> bool:
        """Whether the table names each effect."""
        return all(one.verdict == "named" for one in self.decided)

    def alike(self, name: str) -> tuple[str, ...]:
        """List what the table names and does not distinguish from an effect."""
        if not self.stands:
            return ()
        names = (one.names for one in self.decided if one.verdict == "named" and name in one.names)
        return tuple(other for other in next(names, ()) if other != name)


def verdict_of(candidate: Candidate) -> Verdict:
    """Choose the verdict for one named candidate: a force or a sensor's fault."""
    return "missing_effect" if candidate.term.is_force else "sensor_fault"


def too_few_cycles(baseline: Baseline) -> bool:
    """Check whether too few cycles of free motion, over all releases, stand above friction and noise."""
    seconds = sum(len(window) / window.rate for window in baseline.fit.windows)
    return seconds * baseline.fit.frequency / (2.0 * np.pi) < FEWEST_CYCLES


def why_not_enough(baseline: Baseline, found: Fit) -> str:
    """Explain why the data are not enough, and what to record."""
    if too_few_cycles(baseline):
        return (
            "Fewer than five cycles of free motion stand above friction and noise: too few to distinguish effects. "
            "Release from a larger amplitude, or record for longer."
        )
    return (
        f"The model leaves {three_figures(motion_percent(found))} % of the motion, and the noise of this record, which is "
        "only a guess, may be as large: any model would pass. Look at the record first: is this the right column, and is "
        "the mass swinging freely?"
    )
