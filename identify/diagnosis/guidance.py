"""Guidance: whether releases so far have settled what is missing, or which one to record next."""

from dataclasses import dataclass
from typing import Literal

from identify.diagnosis.diagnose import Diagnosis
from identify.diagnosis.experiment import Experiment, signed_amplitude
from identify.diagnosis.next_release import DECIDES, Limits, NextRelease
from identify.formatting import among, plain_name

State = Literal["go_on", "confirmed", "nothing", "no_name", "alike", "given_up"]

FEWEST = 2
"""Releases without which nothing is settled: what is named on one has predicted nothing yet."""

_REACHED = 0.9
"""Share of the upper limit that some release must have come from: beyond what was released anything may hide."""

MOST = 6


@dataclass(frozen=True, eq=False)
class Guidance:
    """Where a guided test stands: its `state`, why in `words`, and the next `experiment` to go on with; `chosen` has reasons."""

    state: State
    words: str
    experiment: Experiment | None = None
    chosen: NextRelease | None = None

    @property
    def over(self) -> bool:
        """Whether nothing more is to be released."""
        return self.state != "go_on"


def first_release(limits: Limits) -> Guidance:
    """Return the first release, of which nothing is known yet: the geometric mean of the limits."""
    middle = (max(limits.low, 0.05 * limits.high) * limits.high) ** 0.5
    return Guidance(
        "go_on",
        "Nothing is known yet: an amplitude in the middle of the limits leaves room on both sides.",
        Experiment(middle),
    )


def guidance(found: Diagnosis, releases: int, limits: Limits) -> Guidance:
    """Return where a test stands that has recorded so many releases, diagnosed together.

    A name is confirmed by one release more than it has effects, when some release came from the upper limit and every other
    hypothesis lies 13.8 nats behind it.
    """
    if found.verdict == "driven":
        return Guidance("given_up", "The motion is driven; stop the drive and begin again.")
    chosen = found.next_within(limits)
    seen = found.verdict != "not_enough_data" and _reach(found) >= _REACHED * limits.high
    if seen and releases >= max(FEWEST, 1 + len(found.named)):
        if found.named and _margin(found) >= DECIDES:
            return Guidance("confirmed", f"{_named(found)}: confirmed by {releases} releases.", None, chosen)
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
        words = f"{_named(found)} explains it so far; another release must bear it out. {chosen.words}"
        return Guidance("go_on", words, chosen.best.experiment, chosen)
    return Guidance("go_on", chosen.words, chosen.best.experiment, chosen)


def _no_more(found: Diagnosis, chosen: NextRelease | None) -> Guidance:
    why = "" if chosen is None else f" {chosen.words}"
    if found.verdict == "nothing_missing":
        return Guidance("nothing", f"Nothing is missing between the limits.{why}", None, chosen)
    if found.named:
        return Guidance("alike", f"{_named(found)}, or what is the same here.{why}", None, chosen)
    return Guidance("no_name", f"Something is missing that has no name here.{why}", None, chosen)


def _margin(found: Diagnosis) -> float:
    """Return the nats by which what is named leads all other hypotheses."""
    leads = next(one.log_odds for one in found.hypotheses if one.names == found.named)
    return leads - max(one.log_odds for one in found.hypotheses if one.names != found.named)


def _reach(found: Diagnosis) -> float:
    """Return the largest displacement that a release so far began at."""
    return max(max(abs(signed_amplitude(decay)), decay.amplitude) for decay in found.baseline.decays)


def _named(found: Diagnosis) -> str:
    names = among([plain_name(name) for name in found.named])
    return names[:1].upper() + names[1:]


def _largest(found: Diagnosis, limits: Limits) -> Experiment:
    last = max(found.baseline.decays, key=lambda decay: decay.amplitude)
    return Experiment(limits.high if signed_amplitude(last) < 0.0 else -limits.high)
