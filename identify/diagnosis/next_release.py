"""The next release: of those that the rig allows, the one that is expected to tell most between what is still open."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from identify.arrays import Array
from identify.diagnosis.expected_evidence import ExpectedEvidence, draw_parameters, expected_evidence
from identify.diagnosis.experiment import Experiment, has_memory, signed_amplitude
from identify.diagnosis.hypotheses import Hypothesis
from identify.fitting.fit import Fit
from identify.formatting import three_figures
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.priors import RIVALS_WITHIN

OPEN = 2.0 * RIVALS_WITHIN
"""Nats behind the likeliest hypothesis within which another one is open."""

DECIDES = 3.0 * RIVALS_WITHIN
"""Nats beyond which more decide nothing more: three times what distinguishes two hypotheses."""

_ENOUGH = 0.9
"""Share of what decides from which on nothing but the amplitude need be varied."""

_AFRESH = 3.0
"""How many times as much as the same amplitude again a release must show of what can hide: else that was looked for."""

_STEPS = 6
_REACH = (0.25, 1.5)
"""Shares of the largest amplitude so far between which a release is sought where nobody has said what the rig allows."""

_HANDLING_S = 30.0
_REBUILDING_S = 600.0
"""What a release takes besides its record, and what a change to the rig takes: guesses, used to compare experiments."""

_ADDED_MASS = 0.1
_SENSORS = {"displacement": "acceleration", "acceleration": "displacement", "velocity": "acceleration"}


@dataclass(frozen=True)
class Limits:
    """Between which displacements (positive, in their unit) a rig can be released, and with which mass (kg) added.

    `ways` are what can be done besides: "push" the mass, record "longer" or "faster", "rest" it before.
    """

    low: float
    high: float
    mass: float | None = None
    ways: tuple[str, ...] = ("push", "longer", "faster", "rest")


@dataclass(frozen=True)
class Option:
    """An experiment with the evidence that it is expected to give between two hypotheses (nats), and its time (s).

    `scatter` is the standard deviation over what is not known of the parameters, and over noise. `decides` is the evidence
    between all that is open, by their odds, of which no more counts than decides.
    """

    experiment: Experiment
    nats: float
    scatter: float
    seconds: float
    decides: float

    @property
    def worth(self) -> tuple[float, float]:
        """Evidence that decides something, a minute; where that is as much, all evidence."""
        return round(60.0 * self.decides / self.seconds, 2), self.nats


@dataclass(frozen=True, eq=False)
class NextRelease:
    """What to record next, `between` which two hypotheses it decides, and what else was thought of.

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
        """Whether a release within the limits is expected to decide between hypotheses: by as much as distinguishes any two.

        What can still hide must show there better than by doing the same again.
        """
        again = self.same.nats if self.hidden and self.same is not None else 0.0
        return self.best.nats >= max(RIVALS_WITHIN, _AFRESH * again)

    @property
    def words(self) -> str:
        """What to do, with what it is expected to tell."""
        one, other = self.between
        if not self.tells_more and self.hidden:
            return "No release within the limits would show much more of what can still hide than the same again."
        if not self.tells_more:
            why = f"No release within the limits distinguishes {one} from {other}: {_about(self.best.nats)} at best"
            if self.instead is None:
                return f"{why}."
            return f"{why}. {_capital(self._do(self.instead.experiment))} could, with {_about(self.instead.nats)}."
        does = (
            f"It would show a force that can still hide, such as {one},"
            if self.hidden
            else f"It distinguishes {one} from {other}"
        )
        sentence = f"{_capital(self._do(self.best.experiment))}. {does} with {_about(self.best.nats)}."
        if self.same is None or self.same.nats >= 0.5 * self.best.nats:
            return sentence
        return f"{sentence} The same amplitude again would add {_number(self.same.nats)}."

    def amplitude_words(self, experiment: Experiment) -> str:
        """Return the amplitude of an experiment with its unit."""
        if self.unit == "m" and abs(experiment.amplitude) < 1.0:
            return f"{1e3 * experiment.amplitude:.3g} mm".replace("-", "−")
        return f"{experiment.amplitude:.3g} {self.unit}".replace("-", "−")

    def _do(self, one: Experiment) -> str:
        if one.heavier:
            added = (
                f"{one.heavier:.0%} of the mass" if self.mass is None else f"{one.heavier * self.mass:.2g} kg"
            )
            return f"an added mass of {added}, released from {self.amplitude_words(one)},"
        if one.sensor:
            return f"a second sensor, of {one.sensor}, at a release from {self.amplitude_words(one)}"
        way = "push the mass so that it swings to" if one.push else "release from"
        more = [f"record {one.longer:g} times as long"] if one.longer > 1.0 else []
        more += [f"at {one.faster:g} times the rate"] if one.faster > 1.0 else []
        more += ["hold it still for some seconds before"] if one.rested else []
        return ", ".join([f"{way} {self.amplitude_words(one)}", *more])


def next_release(
    decays: Sequence[PreparedDecay], hypotheses: Sequence[Hypothesis], limits: Limits | None = None
) -> NextRelease | None:
    """Return the release that is expected to tell most between hypotheses, for its time; None where none can be simulated.

    `decays` are the releases so far. Where nothing is missing, a release is sought that would show what can still hide.
    Without `limits` amplitudes up to one and a half times the largest so far are thought of.
    """
    last = max(decays, key=lambda decay: decay.amplitude)
    if last.window.force is not None or len(hypotheses) < 2:
        return None
    hidden = hypotheses[0].names == () and hypotheses[0].shape is None
    question = _Question(last, tuple(hypotheses) if hidden else _open(hypotheses), hidden)
    bounds = limits or Limits(_REACH[0] * last.amplitude, _REACH[1] * last.amplitude)
    again = Experiment(_within(signed_amplitude(last), bounds))
    tried = question.ask([*map(Experiment, _amplitudes(bounds, last)), again])
    if not tried or not question.pairs:
        return None
    best = max(tried, key=lambda one: question.decides(one))
    if question.decides(best) < _ENOUGH * DECIDES and not hidden:
        tried += question.ask(_variations(best.experiment, question.considered[0].fit, bounds))
    pair = question.pair(tried)
    options = [question.option(one, pair) for one in tried]
    best_option = max(options, key=lambda one: one.worth)
    instead = None
    if best_option.nats < RIVALS_WITHIN:
        changed = [
            question.option(one, pair) for one in question.ask(_changes(best_option.experiment, last, bounds))
        ]
        instead = max(
            (o for o in changed if o.nats >= RIVALS_WITHIN), key=lambda one: one.worth, default=None
        )
    same = next((option for option in options if option.experiment == again), None)
    names = (question.considered[pair[0]].title, question.considered[pair[1]].title)
    return NextRelease(best_option, same, instead, names, tuple(options), last.window.unit, last.mass, hidden)


@dataclass(frozen=True, eq=False)
class _Question:
    """What is open: hypotheses, the likeliest first. What can `hide` has the usual model for its only rival."""

    last: PreparedDecay
    considered: tuple[Hypothesis, ...]
    hidden: bool

    @cached_property
    def chances(self) -> Array:
        """The odds of each, (hypotheses,); what is refuted, but beside which there is only one, counts as hardly open."""
        return np.exp(np.maximum([one.log_odds for one in self.considered], -OPEN))

    @cached_property
    def drawn(self) -> tuple[Array, ...]:
        """Parameters of each as far as they are not known, (draws, shared)."""
        return tuple(draw_parameters(one, self.last, seed) for seed, one in enumerate(self.considered))

    def ask(self, experiments: Sequence[Experiment]) -> list[ExpectedEvidence]:
        """Return what experiments are expected to tell, those that can be simulated."""
        found = [
            expected_evidence(one, self.last, self.considered, pairs=self.pairs, drawn=self.drawn)
            for one in experiments
        ]
        return [one for one in found if one is not None]

    @cached_property
    def pairs(self) -> tuple[tuple[int, int], ...]:
        """Each hypothesis, by its place, with a rival that can be refuted: one that contains it can follow it."""
        every = range(len(self.considered))
        return tuple((i, j) for i in every for j in every if i != j and self._refutable(i, j))

    def _refutable(self, truth: int, rival: int) -> bool:
        one, other = self.considered[truth], self.considered[rival]
        if other.shape is not None or (self.hidden and other.names):
            return False
        return one.shape is not None or not other.contains(one)

    def decides(self, found: ExpectedEvidence) -> float:
        """Return the evidence of an experiment between all pairs by their odds, of each no more than decides.

        0 where most motions run away.
        """
        weights = np.array([self.chances[i] * self.chances[j] for i, j in self.pairs])
        nats = [np.nanmean(np.minimum(found.nats[i, j], DECIDES)) for i, j in self.pairs]
        known = np.isfinite(nats)  # not of a motion that runs away
        if weights[known].sum() < 0.5 * weights.sum():
            return 0.0
        return float(np.sum(weights[known] * np.array(nats)[known]) / weights[known].sum())

    def pair(self, tried: Sequence[ExpectedEvidence]) -> tuple[int, int]:
        """Return the likeliest pair that some experiment decides; the likeliest of all where none does."""
        best = max(tried, key=self.decides)
        ranked = sorted(self.pairs, key=lambda pair: -self.chances[pair[0]] * self.chances[pair[1]])
        able = [(i, j) for i, j in ranked if np.nanmean(best.nats[i, j]) >= RIVALS_WITHIN]
        return (able or ranked)[0]

    def option(self, found: ExpectedEvidence, pair: tuple[int, int]) -> Option:
        """Return an experiment with what it is expected to tell between two hypotheses."""
        nats, one = found.nats[pair], found.experiment
        mean = float(np.nan_to_num(np.nanmean(nats)))
        noise = 2.0 * mean  # the variance of half a difference of chi-square
        length = one.longer * len(self.last.window) / self.last.window.rate
        seconds = (_REBUILDING_S if one.changes_rig else 0.0) + _HANDLING_S + length
        return Option(
            one, mean, float(np.sqrt(np.nan_to_num(np.nanvar(nats)) + noise)), seconds, self.decides(found)
        )


def _open(hypotheses: Sequence[Hypothesis]) -> tuple[Hypothesis, ...]:
    """Return the hypotheses that are open; the two likeliest where only one is."""
    found = [one for one in hypotheses if hypotheses[0].log_odds - one.log_odds < OPEN]
    return tuple(found if len(found) > 1 else hypotheses[:2])


def _figures(amplitude: float) -> float:
    """Return an amplitude to three figures: no hand and no stepper meets more."""
    return float(f"{amplitude:.3g}")


def _amplitudes(limits: Limits, last: PreparedDecay) -> list[float]:
    side = float(np.sign(signed_amplitude(last)))
    sizes = np.geomspace(limits.low, limits.high, _STEPS) if limits.low > 0.0 else [limits.high]
    return [way * side * _figures(size) for size in sizes for way in (1.0, -1.0)]


def _within(amplitude: float, limits: Limits) -> float:
    return float(np.sign(amplitude) * np.clip(_figures(abs(amplitude)), limits.low, limits.high))


def _variations(best: Experiment, found: Fit, limits: Limits) -> list[Experiment]:
    """Return what an operator can do otherwise at the best amplitude."""
    every = {
        "push": replace(best, push=True),
        "longer": replace(best, longer=2.0),
        "faster": replace(best, faster=4.0),
        "rest": replace(best, rested=True),
    }
    if not has_memory(found) or found.windows[0].pre_release is not None:
        every.pop("rest")
    return [experiment for way, experiment in every.items() if way in limits.ways]


def _changes(best: Experiment, last: PreparedDecay, limits: Limits) -> list[Experiment]:
    heavier = limits.mass / last.mass if limits.mass and last.mass else _ADDED_MASS
    sensor = _SENSORS[last.window.channels[0]]
    more = [replace(best, sensor=sensor)] if sensor not in last.window.channels else []
    return [replace(best, heavier=heavier), *more]


def _about(nats: float) -> str:
    return f"about {_number(nats)} nats"


def _number(nats: float) -> str:
    return "more than 1000" if nats > 1000.0 else three_figures(nats) if nats < 1.0 else f"{nats:.0f}"


def _capital(sentence: str) -> str:
    return sentence[:1].upper() + sentence[1:]
