"""Guidance: whether releases so far have settled what is missing, or which one to record next."""

from dataclasses import dataclass
from typing import Literal

from identify.diagnosis.diagnose import Diagnosis
from identify.diagnosis.experiment import Experiment, signed_amplitude
from identify.diagnosis.next_release import DECIDES, Limits, NextRelease
from identify.formatting import among, plain_name

State = Literal["go_on", "confirmed", "nothing", "no_name", "alike", "given_up"]

FEWEST = 2
"""Releases without which no name is confirmed: what is named on one has predicted nothing yet."""

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

    A name is confirmed by two releases or more, when every hypothesis that a release could refute lies 13.8 nats behind it.
    """
    if found.verdict == "driven":
        return Guidance("given_up", "The motion is driven; stop the drive and begin again.")
    chosen = found.next_within(limits)
    tells = chosen is not None and chosen.tells_more
    if releases >= FEWEST:
        if found.named and _margin(found) >= DECIDES:
            return Guidance(
                "confirmed", f"{_named(found)} is confirmed by {releases} releases.", None, chosen
            )
        if found.verdict in ("unknown_effect", "unconfirmed") and found.hypotheses[0].shape is not None:
            words = "Something is missing that has no name here, as all releases say."
            return Guidance("no_name", words, None, chosen)
        if not tells and found.verdict != "not_enough_data":
            return _no_more(found, chosen)
    if releases >= MOST:
        return Guidance("given_up", f"{MOST} releases have not settled it.", None, chosen)
    if chosen is None or found.verdict == "not_enough_data":
        return Guidance(
            "go_on",
            "Too little is known to choose: the largest amplitude shows most.",
            _largest(found, limits),
        )
    if found.named and not _rivals(found) and _margin(found) >= DECIDES:
        words = f"{_named(found)} explains this release; another amplitude must bear it out. {chosen.words}"
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


def _rivals(found: Diagnosis) -> tuple[str, ...]:
    return found.suspects[0].rivals


def _named(found: Diagnosis) -> str:
    names = among([plain_name(name) for name in found.named])
    return names[:1].upper() + names[1:]


def _largest(found: Diagnosis, limits: Limits) -> Experiment:
    last = max(found.baseline.decays, key=lambda decay: decay.amplitude)
    return Experiment(limits.high if signed_amplitude(last) < 0.0 else -limits.high)
