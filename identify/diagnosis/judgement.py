"""The judgement: what is claimed, what is not told apart, what is to be said. It is decided here and nowhere else.

Here where the floor is reached or sure; off it in `floor_not_reached`. What each candidate's reason is worth: `ranking`.
"""

from collections.abc import Callable
from dataclasses import replace

from identify.curves.confirmation import Confirmation
from identify.diagnosis.beside_walk import may_be_named, with_walk
from identify.diagnosis.floor_not_reached import at_a_guess, by_curves, unclaimed
from identify.diagnosis.line_beside import line_beside
from identify.diagnosis.nonparametric_force import free_form
from identify.diagnosis.ranking import Ranked
from identify.diagnosis.search import Pair
from identify.diagnosis.several_effects import Triple, several_effects
from identify.diagnosis.suspects import residual_lines
from identify.diagnosis.verdict import Judgement, verdict_of
from identify.effects.effect import Effect
from identify.evidence.marginal_likelihood import evidence
from identify.fitting.baseline import Baseline
from identify.fitting.corrected_faults import CorrectedFault, unnamed_faults
from identify.fitting.initial_values import scales_of
from identify.fitting.model_error import removed_percent

_DECISIVE = 12.0
"""Nats of evidence below which a force is not claimed while a sensor is known to be faulty: mend that first."""


def judge(
    baseline: Baseline,
    ranked: tuple[Ranked, ...],
    faults: tuple[CorrectedFault, ...],
    library: tuple[Effect, ...],
    predict: Callable[[], Confirmation | None],
) -> Judgement:
    """Return what is to be said: of nothing claimed, of one effect that reaches the floor, of two, or of no name.

    Where the floor is not reached, or could only be guessed, chi-square names nothing: `predict` is asked what the
    curves of the decay confirm. There a line of a sensor is allowed for beside a force.
    """
    faulty = _faulty(baseline, faults)
    beside = None if baseline.floor_is_sure else line_beside(baseline, ranked, library)
    if beside is not None:
        judged = _judged(beside.baseline, beside.ranked, True, library, predict)  # a sensor has a line
        alone = ranked[0].candidate.fit
        as_good = baseline.adequate(alone) and alone.reduced <= judged.final.reduced
        if judged.verdict == "missing_effect" and not as_good:  # two are not preferred to a better one
            return beside.named_with(judged)
    judged = _judged(baseline, ranked, faulty, library, predict)
    if (
        judged.verdict == "nothing_missing" and judged.final is not baseline.fit
    ):  # a line is excused, and explains its part
        faulty = _faulty(baseline, unnamed_faults(baseline.decays, judged.final))
    if judged.verdict == "nothing_missing" and faulty:  # but a sensor's fault, which every fit has corrected
        return replace(judged, verdict="sensor_fault", corrected=True)
    return with_walk(baseline, judged)


def large_enough(baseline: Baseline, judgement: Judgement, worth: float) -> Judgement:
    """Return the judgement, which names no force that removes less than `worth` % of the motion: sure is not yet large.

    What curves confirm removes error of prediction, all else misfit of the free run.
    """
    if judgement.verdict != "missing_effect":
        return judgement
    told = judgement.confirmation
    if told is not None and told.effects:
        before, after = told.usual.typical("motion"), told.found.typical("motion")
        removed = max(before**2 - after**2, 0.0) ** 0.5
    else:
        removed = removed_percent(baseline.fit, judgement.final)
    if removed >= worth:
        return judgement
    ranked = unclaimed(judgement.ranked)
    return Judgement("nothing_missing", ranked, baseline.fit, confirmation=told, too_small=removed)


def _faulty(baseline: Baseline, faults: tuple[CorrectedFault, ...]) -> bool:
    return any(fault.p_value < baseline.alpha for fault in faults)


def _judged(
    baseline: Baseline,
    ranked: tuple[Ranked, ...],
    faulty: bool,
    library: tuple[Effect, ...],
    predict: Callable[[], Confirmation | None],
) -> Judgement:
    """Return what is to be said of a model as it is."""
    top = ranked[0] if ranked else None
    if top is None or not top.claimed:
        return _without_claim(baseline, ranked, predict)
    best = top.candidate
    if best.term.effect.kind == "physics" and top.evidence < _DECISIVE and faulty:
        return Judgement("sensor_fault", ranked, baseline.fit, corrected=True)
    if baseline.adequate(best.fit):
        if not best.plausible:
            shape = free_form(baseline, baseline.fit)
            return Judgement("unknown_effect", ranked, best.fit, shape=shape)
        alone = Judgement(verdict_of(best), ranked, best.fit)
        if not baseline.floor_is_sure:
            return at_a_guess(baseline, alone, predict())
        return _unless_it_walks(baseline, alone)
    return _beyond_one(baseline, ranked, library, predict)


def _without_claim(
    baseline: Baseline, ranked: tuple[Ranked, ...], predict: Callable[[], Confirmation | None]
) -> Judgement:
    if not baseline.adequate(baseline.fit):
        return by_curves(baseline, ranked, predict(), baseline.fit)
    return Judgement("nothing_missing", ranked, baseline.fit)


def _beyond_one(
    baseline: Baseline,
    ranked: tuple[Ranked, ...],
    library: tuple[Effect, ...],
    predict: Callable[[], Confirmation | None],
) -> Judgement:
    """Judge where no single effect reaches the floor: a law between the names, two or three together, or the curves.

    More than one effect is fitted to chi-square only where the floor is sure: two follow any guess of it.
    """
    if not baseline.floor_is_sure:
        return by_curves(baseline, ranked, predict(), ranked[0].candidate.fit)
    found = several_effects(baseline, tuple(entry.candidate for entry in ranked), library)
    if found.law is not None:
        scales = scales_of(baseline.decays[0], residual_lines(baseline.fit))
        law = Ranked(found.law, evidence(baseline.fit, found.law.fit, scales), True)
        return _unless_it_walks(baseline, Judgement("missing_effect", (law, *ranked), found.law.fit))
    several = found.pair or found.triple
    if several is not None:
        judged = _of_pair(ranked, several) if isinstance(several, Pair) else _of_three(ranked, several)
        return _unless_it_walks(baseline, judged)
    return by_curves(baseline, ranked, predict(), found.closest)


def _unless_it_walks(baseline: Baseline, judged: Judgement) -> Judgement:
    """Return a judgement whose forces are distinguishable from a random walk; else one without a name."""
    if may_be_named(baseline, judged):
        return judged
    shape = free_form(baseline, baseline.fit)
    return Judgement("unknown_effect", judged.ranked, baseline.fit, shape=shape)


def _of_pair(ranked: tuple[Ranked, ...], pair: Pair) -> Judgement:
    """Return the judgement that names a pair, the one that is better alone first."""
    names = (pair.first.name, pair.second.name)
    first = next(entry for entry in ranked if entry.candidate.name in names)
    rest = tuple(entry for entry in ranked if entry is not first)
    other = tuple(name for name in names if name != first.candidate.name)
    return Judgement(verdict_of(first.candidate), (first, *rest), pair.second.fit, other)


def _of_three(ranked: tuple[Ranked, ...], three: Triple) -> Judgement:
    """Return the judgement that names three effects, the one that is best alone first."""
    first = next(entry for entry in ranked if entry.candidate.name in three.names)
    rest = tuple(entry for entry in ranked if entry is not first)
    others = tuple(name for name in three.names if name != first.candidate.name)
    return Judgement(verdict_of(first.candidate), (first, *rest), three.fit, others)
