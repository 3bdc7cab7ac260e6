"""The next release: the one that is expected to distinguish the open hypotheses best, of those that the rig allows."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from identify.arrays import Array
from identify.fitting.fit import Fit
from identify.formatting import odds_words, sentence_case
from identify.planning.expected_evidence import ExpectedEvidence, draw_parameters, expected_evidence, refitted
from identify.planning.experiment import Experiment, signed_amplitude
from identify.planning.hypotheses import Hypothesis, odds
from identify.planning.so_far import SoFar
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.priors import DECIDES, DOUBT, RIVALS_WITHIN

OPEN = 2.0 * RIVALS_WITHIN
"""Nats behind the likeliest hypothesis within which another one is open."""

_ENOUGH = 0.9
"""Share of what decides from which on nothing but the amplitude need be varied."""

_AFRESH = 3.0
"""How many times as much as the same amplitude again a release must show of what can hide: else that was looked for."""

_REFITS, _AT_A_GLANCE = 6, 2
"""Most experiments of which rivals are refitted to the records themselves, those that lead: in a guided test, and else."""

_COUNTS = 0.1
"""Share of the likeliest pair's odds from which on a pair is refitted too."""

_STEPS = 6
_REACH = (0.25, 1.5)
"""Shares of the largest amplitude so far between which a release is sought where nobody has said what the rig allows."""

_HANDLING_S = 30.0
"""What a release takes besides its record: a guess, used to compare experiments."""

_ADDED_MASS = 0.1
_SENSORS = {"displacement": "acceleration", "acceleration": "displacement", "velocity": "acceleration"}


@dataclass(frozen=True)
class Limits:
    """The displacements (positive, in their unit) between which a rig can be released.

    `ways` are other things that can be done: "push" the mass, record "longer" or "faster", "rest" it before.
    """

    low: float
    high: float
    ways: tuple[str, ...] = ("push", "longer", "faster", "rest")


@dataclass(frozen=True)
class Option:
    """An experiment with the evidence that it should give between two hypotheses (nats).

    `scatter` is the standard deviation over what is not known of the parameters, and over noise. `worth` is the evidence a
    minute that decides something between all that is open; where that is as much, all evidence between the two.
    """

    experiment: Experiment
    nats: float
    scatter: float
    worth: tuple[float, float]


@dataclass(frozen=True, eq=False)
class NextRelease:
    """What to record next, `between` which two hypotheses it decides, and the other experiments considered.

    `best` is feasible without a change to the rig, `same` the last amplitude once more, None where that is not possible.
    `instead` is a change to the rig that would tell enough where no release does, None elsewhere.
    """

    best: Option
    same: Option | None
    instead: Option | None
    between: tuple[str, str]
    options: tuple[Option, ...]
    unit: str
    mass: float | None = None
    hidden: bool = False

    @property
    def tells_more(self) -> bool:
        """Whether a release within the limits is expected to decide between hypotheses.

        What can still hide must show there better than by doing the same again.
        """
        again = self.same.nats if self.hidden and self.same is not None else 0.0
        return self.best.nats >= max(RIVALS_WITHIN, _AFRESH * again)

    @property
    def words(self) -> str:
        """What to do, and what it is expected to show."""
        one, other = self.between
        if not self.tells_more and self.hidden:
            return "No release helps: none within the limits shows much more of a hidden force than the same one again."
        if not self.tells_more:
            best = odds_words(self.best.nats)
            if self.instead is None:
                return f"No release helps: none within the limits distinguishes {one} from {other} (odds of {best} at best)."
            does = sentence_case(self._do(self.instead.experiment))
            could = (
                f"{does} could distinguish {one} from {other}, with odds of {odds_words(self.instead.nats)}"
            )
            return f"{could}. As it is, no release within the limits does: odds of {best} at best."
        does = (
            f"It would show a force that can still hide, such as {one},"
            if self.hidden
            else f"It should distinguish {one} from {other}"
        )
        sentence = f"{sentence_case(self._do(self.best.experiment))}. {does} with odds of {odds_words(self.best.nats)}."
        if self.same is None or self.same.nats >= min(0.5 * self.best.nats, DECIDES):
            return sentence
        return f"{sentence} The same amplitude again would give odds of {odds_words(self.same.nats)}."

    def _do(self, one: Experiment) -> str:
        amplitude = amplitude_words(one.amplitude, self.unit)
        if one.heavier:
            added = (
                f"{one.heavier:.0%} of the mass" if self.mass is None else f"{one.heavier * self.mass:.2g} kg"
            )
            return f"an added mass of {added}, released from {amplitude},"
        if one.sensor:
            return f"a second sensor, of {one.sensor}, at a release from {amplitude}"
        way = "push the mass so that it swings to" if one.push else "release from"
        more = [f"record {one.longer:g} times as long"] if one.longer > 1.0 else []
        more += [f"at {one.faster:g} times the rate"] if one.faster > 1.0 else []
        more += ["hold it still for some seconds before"] if one.rested else []
        return ", ".join([f"{way} {amplitude}", *more])


def amplitude_words(amplitude: float, unit: str) -> str:
    """Return an amplitude with its unit, mm for m."""
    in_millimetres = unit == "m" and abs(amplitude) < 1.0
    words = f"{1e3 * amplitude:.3g} mm" if in_millimetres else f"{amplitude:.3g} {unit}"
    return words.replace("-", "−")


def next_release(
    decays: Sequence[PreparedDecay],
    hypotheses: Sequence[Hypothesis],
    limits: Limits | None = None,
    hiding: Sequence[Hypothesis] = (),
) -> NextRelease | None:
    """Choose the release with the most expected evidence for its time; None where nothing is open or can be simulated.

    `decays` are the releases so far. It decides between the hypotheses that are open, and shows what can still hide beside
    the likeliest, which is `hiding`, or, where nothing is missing, all others. Without `limits` the two likeliest count as
    open where the odds have settled it, and amplitudes up to one and a half times the largest so far are thought of.
    """
    last = max(decays, key=lambda decay: decay.amplitude)
    if last.window.force is not None:
        return None
    lead, refits = hypotheses[0], _AT_A_GLANCE if limits is None else _REFITS
    if lead.has_law and not lead.names:
        question = _Question(last, tuple(hypotheses), 1, refits)
    else:
        open_ = _open(hypotheses, at_least=2 if limits is None else 1)
        question = _Question(last, (*open_, *hiding), len(open_), refits)
    if not question.pairs:
        return None
    bounds = limits or Limits(_REACH[0] * last.amplitude, _REACH[1] * last.amplitude)
    again = Experiment(_within(signed_amplitude(last), bounds))
    tried = question.refined(question.ask([*map(Experiment, _amplitudes(bounds, last)), again]))
    if not tried:
        return None
    best = max((one for one in tried if one.refitted), key=question.worth)
    if question.first_hiding > 1 and question.decides(best) < _ENOUGH * DECIDES:
        varied = question.ask(_variations(best.experiment, lead.fit, bounds))
        tried = question.refined([*tried, *varied])
    pair = question.pair(tried)
    asked = (again, best.experiment)
    tried = [question.refitted(one, [pair]) if one.experiment in asked else one for one in tried]
    options = tuple(question.option(one, pair) for one in tried)
    known = (option for option, one in zip(options, tried, strict=True) if pair in one.refitted)
    chosen = max(known, key=lambda option: option.worth)
    same = next((option for option in options if option.experiment == again), None)
    instead, hidden = None, pair[0] >= question.first_hiding
    if chosen.nats < RIVALS_WITHIN and not hidden:
        changed = (question.option(one, pair) for one in question.ask(_changes(chosen.experiment, last)))
        enough = (option for option in changed if option.nats >= RIVALS_WITHIN)
        instead = max(enough, key=lambda option: option.nats, default=None)
    names = (question.considered[pair[0]].title, question.considered[pair[1]].title)
    return NextRelease(chosen, same, instead, names, options, last.window.unit, last.mass, hidden)


@dataclass(frozen=True, eq=False)
class _Question:
    """The open hypotheses, the likeliest first, and from `first_hiding` on what can hide beside the likeliest."""

    last: PreparedDecay
    considered: tuple[Hypothesis, ...]
    first_hiding: int
    refits: int

    @cached_property
    def chances(self) -> Array:
        """The odds of each, (hypotheses,); the second of two counts as hardly open though it is refuted."""
        return np.asarray(np.exp(np.clip([one.log_odds for one in self.considered], -OPEN, 0.0)))

    @cached_property
    def drawn(self) -> tuple[Array, ...]:
        """Draws of the errors of each hypothesis's parameters, (draws, shared)."""
        return tuple(draw_parameters(one, self.last, seed) for seed, one in enumerate(self.considered))

    @cached_property
    def so_far(self) -> tuple[SoFar, ...]:
        """Each hypothesis as fitted to the releases so far."""
        return tuple(SoFar.of(one) for one in self.considered)

    def ask(self, experiments: Sequence[Experiment]) -> list[ExpectedEvidence]:
        """Estimate the evidence of those experiments that can be simulated, by linear theory."""
        found = [expected_evidence(one, self.last, self.considered, pairs=self.pairs) for one in experiments]
        return [one for one in found if one is not None]

    def refitted(self, one: ExpectedEvidence, pairs: Sequence[tuple[int, int]]) -> ExpectedEvidence:
        """Refit some pairs for an experiment, where it has no refits yet."""
        wanted = [pair for pair in pairs if pair not in one.refitted]
        if not wanted:
            return one
        return refitted(one, self.considered, self.so_far, pairs=wanted, drawn=self.drawn)

    def refined(self, tried: list[ExpectedEvidence]) -> list[ExpectedEvidence]:
        """Refit the pairs that count most for the leading experiments."""
        weights = self._weights
        leading = [
            pair
            for pair, weight in zip(self.pairs, weights, strict=True)
            if weight >= _COUNTS * weights.max()
        ]
        for _ in range(self.refits if tried else 0):
            at = max(range(len(tried)), key=lambda i: self.worth(tried[i]))
            pairs = {*leading, self.pair(tried)}
            again = self.refitted(tried[at], sorted(pairs))
            if again is tried[at]:
                break
            tried = [*tried[:at], again, *tried[at + 1 :]]
        return tried

    def worth(self, one: ExpectedEvidence) -> tuple[float, float]:
        """Return what an experiment is worth between the two hypotheses that it decides best."""
        return self.option(one, self.pair([one])).worth

    @cached_property
    def pairs(self) -> tuple[tuple[int, int], ...]:
        """The places of each hypothesis and a rival that can be refuted: a rival that contains it cannot."""
        every = range(len(self.considered))
        return tuple((i, j) for i in every for j in every if i != j and self._refutable(i, j))

    def _refutable(self, truth: int, rival: int) -> bool:
        one, other = self.considered[truth], self.considered[rival]
        if truth >= self.first_hiding:
            return rival == 0 and other.has_law
        if rival >= self.first_hiding or not other.has_law:
            return False
        return not one.has_law or not other.contains(one)

    @cached_property
    def _weights(self) -> Array:
        return np.array([self.chances[i] * self.chances[j] for i, j in self.pairs])

    def decides(self, found: ExpectedEvidence) -> float:
        """Return the evidence of an experiment over all pairs, weighted by their odds, each capped at what decides.

        0 where most motions diverge.
        """
        weights = self._weights
        nats = np.array([_mean(np.minimum(found.nats[pair], DECIDES)) for pair in self.pairs])
        known = np.isfinite(nats)  # nan: the motion diverged
        if weights[known].sum() < 0.5 * weights.sum():
            return 0.0
        return float(np.sum(weights[known] * nats[known]) / weights[known].sum())

    def pair(self, tried: Sequence[ExpectedEvidence]) -> tuple[int, int]:
        """Choose the likeliest pair that an experiment decides, open ones before hidden ones; else the likeliest pair."""
        best, chances = max(tried, key=self.decides), self.chances
        ranked = sorted(self.pairs, key=lambda p: (p[0] >= self.first_hiding, -chances[p[0]] * chances[p[1]]))
        able = [pair for pair in ranked if _mean(best.nats[pair]) >= RIVALS_WITHIN]
        return (able or ranked)[0]

    def option(self, found: ExpectedEvidence, pair: tuple[int, int]) -> Option:
        """Add to an experiment the evidence expected between two hypotheses."""
        nats, one = found.nats[pair], found.experiment
        mean = float(np.nan_to_num(_mean(nats)))
        noise = 2.0 * mean  # the variance of half a difference of chi-square
        spread = float(np.nanvar(nats)) if np.isfinite(nats).any() else 0.0
        seconds = _HANDLING_S + one.longer * len(self.last.window) / self.last.window.rate
        worth = (round(60.0 * self.decides(found) / seconds, 2), mean)
        return Option(one, mean, float(np.sqrt(spread + noise)), worth)


def _mean(nats: Array) -> float:
    """Return the mean of the known values; nan where none is known."""
    return float(np.nanmean(nats)) if np.isfinite(nats).any() else np.nan


def _open(hypotheses: Sequence[Hypothesis], *, at_least: int) -> tuple[Hypothesis, ...]:
    """List the open hypotheses: only the likeliest where all others together have no more than DOUBT."""
    if odds(hypotheses)[0] >= 1.0 - DOUBT:
        return tuple(hypotheses[:at_least])
    return tuple(one for one in hypotheses if hypotheses[0].log_odds - one.log_odds < OPEN)


def _figures(amplitude: float) -> float:
    """Round an amplitude to three figures: no hand and no stepper is more exact."""
    return float(f"{amplitude:.3g}")


def _amplitudes(limits: Limits, last: PreparedDecay) -> list[float]:
    side = float(np.sign(signed_amplitude(last)))
    sizes = np.geomspace(limits.low, limits.high, _STEPS)
    return [way * side * _figures(size) for size in sizes for way in (1.0, -1.0)]


def _within(amplitude: float, limits: Limits) -> float:
    return float(np.sign(amplitude) * np.clip(_figures(abs(amplitude)), limits.low, limits.high))


def _variations(best: Experiment, found: Fit, limits: Limits) -> list[Experiment]:
    """List the other things that an operator can do at the best amplitude."""
    every = {
        "push": replace(best, push=True),
        "longer": replace(best, longer=2.0),
        "faster": replace(best, faster=4.0),
        "rest": replace(best, rested=True),
    }
    memory = any(term.force.states and term.force.fading_memory for term in found.model.forces)
    if not memory or found.windows[0].pre_release is not None:
        every.pop("rest")
    return [experiment for way, experiment in every.items() if way in limits.ways]


def _changes(best: Experiment, last: PreparedDecay) -> list[Experiment]:
    """List the changes to the rig that may help: an added mass, or a sensor of what is not measured."""
    sensor = _SENSORS[last.window.channels[0]]
    more = [replace(best, sensor=sensor)] if sensor not in last.window.channels else []
    return [replace(best, heavier=_ADDED_MASS), *more]
