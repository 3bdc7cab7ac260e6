"""Guidance: whether the releases so far have settled what is missing, or which one to record next."""

from dataclasses import dataclass
from typing import Literal

from identify.diagnosis.diagnose import Diagnosis
from identify.formatting import among, plain_name, sentence_case, two_figures
from identify.planning.experiment import Experiment, signed_amplitude
from identify.planning.hypotheses import Hypothesis, odds
from identify.planning.next_release import Limits, NextRelease, amplitude_words
from identify.priors import DECIDES, DOUBT, RIVALS_WITHIN

State = Literal["go_on", "confirmed", "nothing", "no_name", "alike", "given_up"]

FEWEST = 2
"""Releases without which nothing is settled: what is named on one has predicted nothing yet."""

_REACHED = 0.9
"""Share of the upper limit from which a law outside the library must have been seen: no fit says what hides beyond."""

MOST = 6


@dataclass(frozen=True, eq=False)
class Guidance:
    """Where a guided test stands: its `state`, why in `words`, the next `experiment` to go on with; `chosen` has why.

    `named` is what was found when it is over, `alike` what no release distinguishes from it.
    """

    state: State
    words: str
    experiment: Experiment | None = None
    chosen: NextRelease | None = None
    named: tuple[str, ...] = ()
    alike: tuple[tuple[str, ...], ...] = ()

    @property
    def over(self) -> bool:
        """Whether nothing more is to be released."""
        return self.state != "go_on"


def first_release(limits: Limits) -> Guidance:
    """Choose the first release, before anything is known: the geometric mean of the limits."""
    middle = float(f"{(max(limits.low, 0.05 * limits.high) * limits.high) ** 0.5:.2g}")
    return Guidance(
        "go_on",
        "Nothing is known yet: begin in the middle of the limits, with room on both sides.",
        Experiment(middle),
    )


def guidance(found: Diagnosis, releases: int, limits: Limits) -> Guidance:
    """Decide whether a test is over after so many releases, diagnosed together, or what to record next.

    It ends when no release is expected to tell more: between the open hypotheses, or about what can still hide beside
    the likeliest. A name needs one release more than it has effects. Where a law of a family explains more, that is
    confirmed. A law outside the library predicts nothing beyond the largest release: so one must come from the upper limit.
    """
    if found.verdict == "driven":
        return Guidance("given_up", "The motion is driven; stop the drive and begin again.")
    chosen = found.next_within(limits)
    far = _reach(found) >= _REACHED * limits.high
    more = chosen is not None and chosen.tells_more
    named, nameless = leading(found), found.verdict in ("unknown_effect", "unconfirmed")
    enough = releases >= max(FEWEST, 1 + len(named)) and found.verdict != "not_enough_data"
    if enough and nameless and far and not found.hypotheses[0].has_law:
        words = "Something is missing, and no effect can be named; all releases agree."
        return Guidance("no_name", words, None, chosen)
    if enough and not more and (far or not nameless):
        return _no_more(found, releases, chosen, limits)
    if releases >= MOST:
        return Guidance("given_up", f"{MOST} releases have not decided it.", None, chosen)
    if chosen is None or not more:
        words = "Another release must confirm it: the largest amplitude shows most."
        return Guidance("go_on", words, _largest(found, limits), chosen)
    if named and _settled(found):
        words = f"{_named(named)} explains it so far. {chosen.words}"
        return Guidance("go_on", words, chosen.best.experiment, chosen)
    return Guidance("go_on", chosen.words, chosen.best.experiment, chosen)


def what_it_gave(told: Guidance, before: Diagnosis, after: Diagnosis) -> float | None:
    """Return the evidence (nats) that a release gave between the two hypotheses it was meant to distinguish.

    This is half of the amount by which the second's chi-square rose more than the first's; None where the release was
    meant to show what can hide, or where one of the two was not fitted again.
    """
    chosen = told.chosen
    if chosen is None or chosen.hidden or chosen.best.experiment != told.experiment:
        return None
    rises = []
    for title in chosen.between:
        first, last = (
            next((h.fit.chi_square for h in found.hypotheses if h.title == title and h.has_law), None)
            for found in (before, after)
        )
        if first is None or last is None:
            return None
        rises.append(last - first)
    return 0.5 * (rises[1] - rises[0])


def _no_more(found: Diagnosis, releases: int, chosen: NextRelease | None, limits: Limits) -> Guidance:
    """Decide how a test ends when no further release would tell more."""
    if found.verdict == "nothing_missing":
        why = "" if chosen is None else f" {chosen.words}"
        return Guidance("nothing", f"Nothing is missing between the limits.{why}", None, chosen)
    if not found.named:
        words = "Something is missing, and no effect can be named."
        return Guidance("no_name", words, None, chosen)
    named, near = leading(found), _near(found)
    if named != found.named and not near:
        nearly = among([plain_name(name) for name in found.named])
        words = f"{_named(named)}: {nearly} would explain the releases less well."
        return Guidance("confirmed", words, None, chosen, named)
    if all(_less_simple(found, one) for one in near):
        simplest = " as the simplest law" if near else ""
        words = f"{_named(named)}: confirmed by {releases} releases{simplest}. {_not_excluded(found, near, limits)}"
        return Guidance("confirmed", words.strip(), None, chosen, named)
    alike = among([one.title for one in near])
    words = f"{_named(named)}, or {alike}: no release within the limits distinguishes them."
    if chosen is not None and chosen.instead is not None and not chosen.hidden:
        words = f"{_named(named)}, or a law that acts the same within the limits. {chosen.words}"
    return Guidance("alike", words, None, chosen, named, tuple(one.names for one in near))


def leading(found: Diagnosis) -> tuple[str, ...]:
    """List what a verdict names; or what leads beside it: a law of a family, or one of several effects exchanged."""
    return found.hypotheses[0].names if found.named else ()


def _not_excluded(found: Diagnosis, near: list[Hypothesis], limits: Limits) -> str:
    """Say what a test cannot exclude where a law is confirmed: other laws, and what begins above all releases; or ""."""
    parts, reach = [], _reach(found)
    if reach < _REACHED * limits.high:
        amplitude = amplitude_words(reach, found.baseline.decays[0].window.unit)
        parts.append(f"A force that begins only above {amplitude} could not be seen.")
    if near:
        has, explains = ("has", "explains") if len(near) == 1 else ("have", "explain")
        laws = among([one.title for one in near])
        parts.append(f"This rig cannot exclude {laws}, which {has} more parameters and {explains} no more.")
    named = found.hypotheses[0].fit
    for one in found.hypotheses:
        if one.free is not None and 0.5 * (one.free.chi_square - named.chi_square) < DECIDES:
            effect = next(s.effect for s in found.suspects if s.effect.name == one.names[0])
            units = {p.name: p.unit for p in effect.parameters}
            ends = " and ".join(
                f"{key} beyond {two_figures(value)} {units[key]}" for key, value in one.within.items()
            )
            parts.append(f"This rig cannot exclude {one.title} with {ends}: here that is the same law.")
    return " ".join(parts)


def _settled(found: Diagnosis) -> bool:
    """Check that all hypotheses but the named one share a probability of DOUBT at most."""
    return found.hypotheses[0].names == leading(found) and bool(odds(found.hypotheses)[0] >= 1.0 - DOUBT)


def _near(found: Diagnosis) -> list[Hypothesis]:
    """List the hypotheses still open against what is named: all others together have DOUBT at most."""
    chances, named = odds(found.hypotheses), leading(found)
    others = [(c, one) for c, one in zip(chances, found.hypotheses, strict=True) if one.names != named]
    left, near = sum(c for c, _ in others), []
    for chance, one in others:
        if left <= DOUBT:
            break
        near.append(one)
        left -= chance
    return near


def _less_simple(found: Diagnosis, other: Hypothesis) -> bool:
    """Check whether another hypothesis has more parameters than what is named, yet explains no more."""
    named = found.hypotheses[0]
    own = len(other.fit.parameters) + len(other.within)
    more = own > len(named.fit.parameters)
    return more and 0.5 * (named.fit.chi_square - other.fit.chi_square) < RIVALS_WITHIN


def _reach(found: Diagnosis) -> float:
    """Return the largest displacement that a release so far began at."""
    return max(max(abs(signed_amplitude(decay)), decay.amplitude) for decay in found.baseline.decays)


def _named(effects: tuple[str, ...]) -> str:
    return sentence_case(among([plain_name(name) for name in effects]))


def _largest(found: Diagnosis, limits: Limits) -> Experiment:
    return Experiment(limits.high if signed_amplitude(found.baseline.largest) < 0.0 else -limits.high)
