"""The judgement: what is claimed, what is not told apart, what is to be said. It is decided here and nowhere else."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from identify.arrays import Array
from identify.curves.confirmation import MOST_RIVALS, WORTH, Confirmation, complexity
from identify.diagnosis.confirmed_fit import fit_confirmed
from identify.diagnosis.nonparametric_force import NonparametricForce, nonparametric_force
from identify.diagnosis.null_distribution import NullDistribution
from identify.diagnosis.rest_evidence import at_rest
from identify.diagnosis.search import Pair, families, pairs, triple
from identify.diagnosis.suspects import Candidate
from identify.effects.effect import Effect
from identify.fitting.baseline import ADEQUATE, Baseline, force_along_motion
from identify.fitting.corrected_faults import CorrectedFault
from identify.fitting.fit import Fit
from identify.fitting.misfit_errors import with_misfit_errors
from identify.model.model import Term

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
    "unconfirmed": "A misfit that no effect here foretells",
    "driven": "The motion is driven",
    "not_enough_data": "Not enough data",
}

ALPHA = 0.02
"""Probability of claiming an effect where there is none; the promise is 5 %."""

ALPHA_GUESSED = 2e-4
"""The same where the floor could only be guessed: on such records nothing weak is claimed."""

RIVALS_WITHIN = 4.6
"""Nats of evidence (odds of 100 to 1) below which two suspects count as not told apart."""

_NEXT_TO_NOTHING = 0.01
"""Share of chi-square that is left where a name explains nearly all: so much may stay where the floor is sure and is not
reached, or where the free run alone names."""

_NEXT_LEAVES = 3.0
"""A force that leaves less than this many times as much is not told apart from it."""

_CLEAR = 3.0
"""Standard errors, of the misfit that is there, by which a strength must differ from none."""

_PAIR_HELPS = 0.2
"""Share of the best single effect's chi-square below which a pair is worth a third."""

_LINE_LEAVES = 0.5
"""Share of chi-square that a second line may leave where the amplitude beats."""

_DECISIVE = 12.0
"""Nats of evidence below which a force is not claimed while a sensor is known to be faulty: mend that first."""


@dataclass(frozen=True, eq=False)
class Ranked:
    """A candidate with its evidence (nats) and the probability that chance gives any suspect as good a reason.

    `alike` are names of forces that the free run does not tell from it, where the floor was only a guess.
    """

    candidate: Candidate
    evidence: float
    p_value: float
    claimed: bool
    alike: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Judgement:
    """What is to be said of a model.

    `ranked` are the candidates, what the verdict names first; `together` the second effect where it takes two; `final`
    the fit with what was found; `shape` the free form, when something is missing that has no name. `corrected` tells
    that a fault which every fit corrects decides, not a candidate that was tried. `confirmation` is what curves
    foretell, None where they were not asked.
    """

    verdict: Verdict
    ranked: tuple[Ranked, ...]
    final: Fit
    together: tuple[str, ...] = ()
    shape: NonparametricForce | None = None
    corrected: bool = False
    confirmation: Confirmation | None = None


def alpha(baseline: Baseline) -> float:
    """Return the probability of a false claim that is allowed on these records."""
    return ALPHA if baseline.floor_is_sure else ALPHA_GUESSED


def rivals_of(entry: Ranked, ranked: tuple[Ranked, ...]) -> tuple[str, ...]:
    """Return the names of the claimed candidates that explain the record as well as one of them does."""
    if not entry.claimed or entry.alike:
        return entry.alike
    return tuple(
        other.candidate.name
        for other in ranked
        if other is not entry and other.claimed and abs(other.evidence - entry.evidence) < RIVALS_WITHIN
    )


def rank(baseline: Baseline, tried: tuple[Candidate, ...], chance: NullDistribution) -> tuple[Ranked, ...]:
    """Return the candidates with their evidence: plausible claims first, then implausible ones, then the rest."""
    dispersion, allowed = _dispersion(baseline, tried), alpha(baseline)
    ranked = []
    for candidate in tried:
        drop = candidate.gain / dispersion
        evidence = chance.surprise(candidate.name, drop) + at_rest(baseline.decays, candidate)
        p_value = chance.p_value(candidate.name, drop) if evidence > 0.0 else 1.0
        ranked.append(Ranked(candidate, evidence, p_value, p_value < allowed))
    return tuple(sorted(ranked, key=_order))


def _order(entry: Ranked) -> tuple[int, float]:
    tier = 2 if not entry.claimed else 0 if entry.candidate.plausible else 1
    return tier, -entry.evidence


def _dispersion(baseline: Baseline, tried: tuple[Candidate, ...]) -> float:
    """Return by how much a misfit that nothing explains widens chance: 1 where the best refit reaches a sure floor."""
    best = min(
        (c.fit for c in tried if c.plausible), key=lambda found: found.chi_square, default=baseline.fit
    )
    if baseline.adequate(best) and baseline.floor_is_sure:
        return 1.0
    lengths = []
    for i, window in enumerate(best.windows):
        for channel in window.channels:
            lengths.append(_correlation_length(best.in_noise(channel, i)))
    return max(1.0, best.reduced * float(np.mean(lengths)))


def _correlation_length(values: Array) -> float:
    """Return how many readings count as one, from the autocorrelation up to its first zero."""
    n = len(values)
    power = np.abs(np.fft.rfft(values - values.mean(), 2 * n)) ** 2
    correlation = np.fft.irfft(power)[:n]
    if correlation[0] <= 0.0:
        return 1.0
    correlation = correlation / correlation[0]
    below = np.flatnonzero(correlation < 0.0)
    return float(1.0 + 2.0 * correlation[1 : below[0] if len(below) else n].sum())


def judge(
    baseline: Baseline,
    ranked: tuple[Ranked, ...],
    faults: tuple[CorrectedFault, ...],
    library: tuple[Effect, ...],
    foretell: Callable[[], Confirmation | None],
) -> Judgement:
    """Return what is to be said: of nothing claimed, of one effect that reaches the floor, of two, or of no name.

    Where the floor is not reached, or could only be guessed, chi-square names nothing: `foretell` is asked what the
    curves of the decay confirm.
    """
    faulty = any(fault.significant for fault in faults)
    top = ranked[0] if ranked else None
    if top is None or not top.claimed:
        return _without_claim(baseline, ranked, faulty, foretell)
    best = top.candidate
    if best.term.effect.kind == "physics" and top.evidence < _DECISIVE and faulty:
        return Judgement("sensor_fault", ranked, baseline.fit, corrected=True)
    if baseline.adequate(best.fit):
        if not best.plausible:
            shape = _free_form(baseline, baseline.fit)
            return Judgement("unknown_effect", ranked, best.fit, shape=shape)
        alone = Judgement(_verdict_of(best), ranked, best.fit)
        return alone if baseline.floor_is_sure else _if_foretold(baseline, alone, foretell())
    return _beyond_one(baseline, ranked, library, foretell)


def _if_foretold(baseline: Baseline, alone: Judgement, found: Confirmation | None) -> Judgement:
    """Return the judgement of one effect that reaches a guessed floor, unless the curves contradict it."""
    best = alone.ranked[0].candidate
    if found is None and best.term.effect.of_time:
        return Judgement("unknown_effect", alone.ranked, best.fit, shape=_free_form(baseline, baseline.fit))
    if found is None or not found.has_law(best.name) or found.usual.typical("motion") < WORTH:
        return replace(alone, confirmation=found)
    reaches_it = best.fit.reduced <= 1.0 + ADEQUATE * baseline.spread  # with no benefit of doubt
    if best.name in found.mentioned or (reaches_it and not found.effects):
        return replace(alone, confirmation=found)
    return _by_curves(baseline, alone.ranked, found, best.fit)


def _without_claim(
    baseline: Baseline,
    ranked: tuple[Ranked, ...],
    faulty: bool,
    foretell: Callable[[], Confirmation | None],
) -> Judgement:
    if not baseline.adequate(baseline.fit):
        return _by_curves(baseline, ranked, foretell(), baseline.fit)
    if faulty:
        return Judgement("sensor_fault", ranked, baseline.fit, corrected=True)
    return Judgement("nothing_missing", ranked, baseline.fit)


def _beyond_one(
    baseline: Baseline,
    ranked: tuple[Ranked, ...],
    library: tuple[Effect, ...],
    foretell: Callable[[], Confirmation | None],
) -> Judgement:
    """Judge where no single effect reaches the floor: a law between the names, two or three together, or the curves.

    More than one effect is fitted to chi-square only where the floor is sure: two follow any guess of it.
    """
    best = ranked[0].candidate
    if not baseline.floor_is_sure:
        return _by_curves(baseline, ranked, foretell(), best.fit)
    alike = _by_family(baseline, ranked)
    if alike is not None:
        return alike
    two = pairs(baseline, tuple(entry.candidate for entry in ranked), library)
    better = two and two[0].plausible and two[0].second.score < best.score
    together = two[0] if better else None
    if together is not None and baseline.adequate(together.second.fit):
        return _of_pair(ranked, together, None)
    if together is not None and together.second.fit.reduced < _PAIR_HELPS * best.fit.reduced:
        three = triple(baseline, two, library)
        if three is not None:
            return _of_three(ranked, *three)
    final = best.fit if together is None else together.second.fit
    return _by_curves(baseline, ranked, foretell(), final)


def _by_curves(
    baseline: Baseline, ranked: tuple[Ranked, ...], found: Confirmation | None, best: Fit
) -> Judgement:
    """Return the judgement of a misfit above the floor: what the curves confirm, however much of it that explains.

    `best` is the fit that comes closest, named or not.
    """
    whole = None if found is None or not found.effects else fit_confirmed(baseline, found)
    if whole is not None and found is not None and not any(_is_clear(whole, e.term) for e in found.effects):
        whole = None
    if (
        whole is not None
        and baseline.floor_is_sure
        and whole.chi_square > _NEXT_TO_NOTHING * baseline.fit.chi_square
    ):
        whole = None  # where the floor is known, half an explanation is not a name
    if found is not None and found.driven:
        return Judgement("driven", ranked, baseline.fit, confirmation=found)
    alone = _by_free_run(baseline, ranked, found) if whole is None else None
    if alone is not None:
        return alone
    if found is None or whole is None:
        if found is None or baseline.floor_is_sure:
            shape = _free_form(baseline, ranked[0].candidate.fit if best is not baseline.fit else best)
            return Judgement("unknown_effect", ranked, best, shape=shape, confirmation=found)
        shape = _free_form(baseline, baseline.fit)
        return Judgement("unconfirmed", ranked, baseline.fit, shape=shape, confirmation=found)
    points = sum(len(curve) for curve in found.curves)
    evidence = float(points * np.log(baseline.fit.chi_square / whole.chi_square))
    first = tuple(
        Ranked(
            Candidate(effect.term, whole, whole.chi_square, baseline.fit.chi_square - whole.chi_square, True),
            evidence,
            float(np.exp(-max(evidence, 0.0))),
            True,
        )
        for effect in found.effects
    )
    rest = tuple(replace(e, claimed=False) for e in ranked if e.candidate.name not in found.names)
    return Judgement(
        "missing_effect",
        (*first, *rest),
        whole,
        found.names[1:],
        _free_form(baseline, whole),
        confirmation=found,
    )


def _is_clear(whole: Fit, term: Term) -> bool:
    """Whether the strength of an effect differs from none by some errors of the misfit that is there."""
    strength = with_misfit_errors(whole).of(term)[term.effect.strength.name]
    return abs(strength.value) > _CLEAR * strength.std


def _by_free_run(
    baseline: Baseline, ranked: tuple[Ranked, ...], found: Confirmation | None
) -> Judgement | None:
    """Return the judgement of one force that the free run singles out where curves confirm none, if there is one.

    Either the amplitude beats and a force without a curve, a second oscillator, leaves much less than any other; or
    one that curves do not deny leaves next to nothing of what the model left, and far less than all but a few others,
    among which no law of time.
    """
    plausible = sorted((entry for entry in ranked if entry.candidate.plausible), key=_misfit)
    if not plausible or plausible[0].candidate.term.effect.kind != "physics":
        return None
    first = plausible[0]
    unseen = found is not None and found.beats and not found.has_law(first.candidate.name)
    beats = unseen and _misfit(first) < _LINE_LEAVES * baseline.fit.chi_square
    near = [
        entry
        for entry in plausible
        if entry.candidate.term.effect.kind == "physics" and _misfit(entry) < _NEXT_LEAVES * _misfit(first)
    ]
    simplest = min(near, key=lambda entry: (complexity(entry.candidate.term.effect), _misfit(entry)))
    best = first if beats else simplest
    left = _misfit(best) / baseline.fit.chi_square
    seen = found is not None and found.has_law(best.candidate.name)
    denied = seen and found is not None and best.candidate.name not in found.mentioned
    apart = len(near) <= MOST_RIVALS + 1 and not any(entry.candidate.term.effect.of_time for entry in near)
    if not (beats or (left < _NEXT_TO_NOTHING and apart and not denied and not baseline.floor_is_sure)):
        return None
    rest = tuple(replace(entry, claimed=False) for entry in ranked if entry is not best)
    final = best.candidate.fit
    shape = _free_form(baseline, final)
    rivals = () if beats else tuple(entry.candidate.name for entry in near if entry is not best)
    return Judgement(
        "missing_effect",
        (replace(best, claimed=True, alike=rivals), *rest),
        final,
        shape=shape,
        confirmation=found,
    )


def _misfit(entry: Ranked) -> float:
    return entry.candidate.fit.chi_square


def _of_pair(ranked: tuple[Ranked, ...], pair: Pair, shape: NonparametricForce | None) -> Judgement:
    """Return the judgement that names a pair, the one that is better alone first."""
    names = (pair.first.name, pair.second.name)
    first = next(entry for entry in ranked if entry.candidate.name in names)
    rest = tuple(entry for entry in ranked if entry is not first)
    other = tuple(name for name in names if name != first.candidate.name)
    return Judgement(_verdict_of(first.candidate), (first, *rest), pair.second.fit, other, shape)


def _of_three(ranked: tuple[Ranked, ...], pair: Pair, third: Candidate) -> Judgement:
    """Return the judgement that names three effects, of the first two the one that is better alone first."""
    two = _of_pair(ranked, pair, None)
    return replace(two, final=third.fit, together=(*two.together, third.name))


def _by_family(baseline: Baseline, ranked: tuple[Ranked, ...]) -> Judgement | None:
    """Return the judgement of a law with a free exponent that reaches the floor where no named effect does."""
    best = next((c for c in families(baseline) if c.plausible and baseline.adequate(c.fit)), None)
    if best is None:
        return None
    evidence = 0.5 * best.gain
    entry = Ranked(best, evidence, float(np.exp(-evidence)), True)
    return Judgement("missing_effect", (entry, *ranked), best.fit)


def _verdict_of(candidate: Candidate) -> Verdict:
    return "missing_effect" if candidate.term.effect.kind == "physics" else "sensor_fault"


def _free_form(baseline: Baseline, found: Fit) -> NonparametricForce:
    largest = max(baseline.decays, key=lambda prepared: prepared.amplitude)
    return nonparametric_force(largest, force_along_motion(largest, found))
