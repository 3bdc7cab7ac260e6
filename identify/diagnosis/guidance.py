"""Guidance: whether releases so far have settled what is missing, or which one to record next."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from identify.diagnosis.diagnose import Diagnosis
from identify.diagnosis.experiment import Experiment, signed_amplitude
from identify.diagnosis.free_exponent import from_members
from identify.diagnosis.hypotheses import Hypothesis
from identify.diagnosis.next_release import DECIDES, Limits, NextRelease
from identify.diagnosis.suspects import Candidate
from identify.effects.families import FAMILIES
from identify.formatting import among, plain_name
from identify.priors import RIVALS_WITHIN

State = Literal["go_on", "confirmed", "nothing", "no_name", "alike", "given_up"]

FEWEST = 2
"""Releases without which nothing is settled: what is named on one has predicted nothing yet."""

_REACHED = 0.9
"""Share of the upper limit that some release must have come from: beyond what was released anything may hide."""

_NEARLY = 0.7
"""Share of the best evidence that will do where a release from the upper limit is wanted besides."""

MOST = 6


@dataclass(frozen=True, eq=False)
class Guidance:
    """Where a guided test stands: its `state`, why in `words`, the next `experiment` to go on with; `chosen` has why.

    `named` is what was found when it is over.
    """

    state: State
    words: str
    experiment: Experiment | None = None
    chosen: NextRelease | None = None
    named: tuple[str, ...] = ()

    @property
    def over(self) -> bool:
        """Whether nothing more is to be released."""
        return self.state != "go_on"


def first_release(limits: Limits) -> Guidance:
    """Return the first release, of which nothing is known yet: the geometric mean of the limits."""
    middle = float(f"{(max(limits.low, 0.05 * limits.high) * limits.high) ** 0.5:.2g}")
    return Guidance(
        "go_on",
        "Nothing is known yet: an amplitude in the middle of the limits leaves room on both sides.",
        Experiment(middle),
    )


def guidance(found: Diagnosis, releases: int, limits: Limits) -> Guidance:
    """Return where a test stands that has recorded so many releases, diagnosed together.

    A name is confirmed by one release more than it has effects, when some release came from the upper limit and every other
    hypothesis lies DECIDES nats behind it. Where a law of a free exponent explains more by as much, that is confirmed.
    """
    if found.verdict == "driven":
        return Guidance("given_up", "The motion is driven; stop the drive and begin again.")
    chosen = found.next_within(limits)
    if chosen is not None and _reach(found) < _REACHED * limits.high:
        chosen = _rather_the_limit(chosen, limits)
    seen = found.verdict != "not_enough_data" and _reach(found) >= _REACHED * limits.high
    if seen and releases >= max(FEWEST, 1 + len(found.named)):
        if found.named and _margin(found) >= DECIDES:
            return _confirmed(found, releases, chosen)
        if found.verdict in ("unknown_effect", "unconfirmed") and found.hypotheses[0].shape is not None:
            words = "Something is missing that has no name here, as all releases say."
            return Guidance("no_name", words, None, chosen)
        if chosen is None or not chosen.tells_more:
            return _no_more(found, chosen)
    if releases >= MOST:
        return Guidance("given_up", f"{MOST} releases have not settled it.", None, chosen)
    if chosen is None or not (chosen.tells_more or seen):
        words = "Above what was released anything may hide: the largest amplitude shows most."
        return Guidance("go_on", words, _largest(found, limits), chosen)
    if found.named and _margin(found) >= DECIDES:
        words = f"{_named(found.named)} explains it so far; another release must bear it out. {chosen.words}"
        return Guidance("go_on", words, chosen.best.experiment, chosen)
    return Guidance("go_on", chosen.words, chosen.best.experiment, chosen)


def _confirmed(found: Diagnosis, releases: int, chosen: NextRelease | None) -> Guidance:
    """Return what is confirmed: what is named, or a law between the names that explains more."""
    law = _between_the_names(found) if len(found.named) == 1 else None
    if law is None:
        words = f"{_named(found.named)}: confirmed by {releases} releases."
        return Guidance("confirmed", words, None, chosen, found.named)
    words = f"{_named((law,))}: {_named(found.named).lower()} comes near, but a free exponent explains the releases better."
    return Guidance("confirmed", words, None, chosen, (law,))


def _between_the_names(found: Diagnosis) -> str | None:
    """Return the law of a free exponent that what is named is a member of, where it explains DECIDES nats more (BIC)."""
    own = found.suspects[0]
    member = Candidate(own.term, own.fit, own.fit.chi_square, 0.0, True)
    baseline = found.baseline
    for family in FAMILIES:
        if own.effect.name not in family.members:
            continue
        for law in from_members(baseline, family, (member,), baseline.fit.degrees):
            gain = 0.5 * (own.fit.chi_square - law.fit.chi_square) - 0.5 * float(np.log(own.fit.degrees))
            if gain >= DECIDES and law.plausible:
                return law.name
    return None


def _no_more(found: Diagnosis, chosen: NextRelease | None) -> Guidance:
    why = "" if chosen is None else f" {chosen.words}"
    if found.verdict == "nothing_missing":
        return Guidance("nothing", f"Nothing is missing between the limits.{why}", None, chosen)
    if found.named:
        if all(_less_simple(found, one) for one in _near(found)):
            words = (
                f"{_named(found.named)}: confirmed as the simplest law. What is left explains no more.{why}"
            )
            return Guidance("confirmed", words, None, chosen, found.named)
        words = f"{_named(found.named)}, or what is the same here.{why}"
        return Guidance("alike", words, None, chosen, found.named)
    return Guidance("no_name", f"Something is missing that has no name here.{why}", None, chosen)


def _margin(found: Diagnosis) -> float:
    """Return the nats by which what is named leads all other hypotheses; of a fault that every fit corrects its evidence."""
    if found.suspects[0].corrected is not None:
        return found.suspects[0].evidence
    leads = next(one.log_odds for one in found.hypotheses if one.names == found.named)
    return leads - max((h.log_odds for h in found.hypotheses if h.names != found.named), default=-np.inf)


def _rather_the_limit(chosen: NextRelease, limits: Limits) -> NextRelease:
    """Return the choice with the upper limit, from which some release must come, where that tells nearly as much."""
    far = [one for one in chosen.options if abs(one.experiment.amplitude) >= _REACHED * limits.high]
    best = max(far, key=lambda one: one.worth, default=chosen.best)
    return replace(chosen, best=best) if best.decides >= _NEARLY * chosen.best.decides else chosen


def _near(found: Diagnosis) -> list[Hypothesis]:
    """Return the hypotheses that are not decided against what is named."""
    leads = next(one.log_odds for one in found.hypotheses if one.names == found.named)
    return [one for one in found.hypotheses if one.names != found.named and leads - one.log_odds < DECIDES]


def _less_simple(found: Diagnosis, other: Hypothesis) -> bool:
    """Whether another hypothesis has more parameters than what is named, and explains no more for it."""
    named = next(one for one in found.hypotheses if one.names == found.named)
    more = len(other.fit.parameters) > len(named.fit.parameters)
    return more and 0.5 * (named.fit.chi_square - other.fit.chi_square) < RIVALS_WITHIN


def _reach(found: Diagnosis) -> float:
    """Return the largest displacement that a release so far began at."""
    return max(max(abs(signed_amplitude(decay)), decay.amplitude) for decay in found.baseline.decays)


def _named(effects: tuple[str, ...]) -> str:
    names = among([plain_name(name) for name in effects])
    return names[:1].upper() + names[1:]


def _largest(found: Diagnosis, limits: Limits) -> Experiment:
    last = max(found.baseline.decays, key=lambda decay: decay.amplitude)
    return Experiment(limits.high if signed_amplitude(last) < 0.0 else -limits.high)
