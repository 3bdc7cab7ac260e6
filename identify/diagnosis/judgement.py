"""The judgement: what is claimed, what is not told apart, what is to be said. It is decided here and nowhere else.

Here where the floor is reached or sure; off it in `off_the_floor`. What each candidate's reason is worth: `ranking`.
"""

from collections.abc import Callable
from dataclasses import replace

from identify.curves.confirmation import Confirmation
from identify.diagnosis.few_releases import FewReleases
from identify.diagnosis.free_exponent import families
from identify.diagnosis.line_beside import line_beside
from identify.diagnosis.nonparametric_force import NonparametricForce
from identify.diagnosis.off_the_floor import by_curves, if_foretold
from identify.diagnosis.ranking import Ranked
from identify.diagnosis.search import Pair, pairs
from identify.diagnosis.triples import Triple, triple
from identify.diagnosis.verdict import Judgement, free_form, verdict_of
from identify.effects.effect import Effect
from identify.fitting.baseline import Baseline
from identify.fitting.corrected_faults import CorrectedFault

_DECISIVE = 12.0
"""Nats of evidence below which a force is not claimed while a sensor is known to be faulty: mend that first."""


def judge(
    baseline: Baseline,
    ranked: tuple[Ranked, ...],
    faults: tuple[CorrectedFault, ...],
    library: tuple[Effect, ...],
    foretell: Callable[[], Confirmation | None],
) -> Judgement:
    """Return what is to be said: of nothing claimed, of one effect that reaches the floor, of two, or of no name.

    Where the floor is not reached, or could only be guessed, chi-square names nothing: `foretell` is asked what the
    curves of the decay confirm. There a line of a sensor is allowed for beside a force.
    """
    faulty = any(fault.significant for fault in faults)
    beside = None if baseline.floor_is_sure else line_beside(baseline, ranked, library)
    if beside is not None:
        judged = _judged(beside.baseline, beside.ranked, True, library, foretell)  # a sensor has a line
        alone = ranked[0].candidate.fit
        as_good = baseline.adequate(alone) and alone.reduced <= judged.final.reduced
        if judged.verdict == "missing_effect" and not as_good:  # two are not preferred to a better one
            return beside.named_with(judged)
    return _judged(baseline, ranked, faulty, library, foretell)


def _judged(
    baseline: Baseline,
    ranked: tuple[Ranked, ...],
    faulty: bool,
    library: tuple[Effect, ...],
    foretell: Callable[[], Confirmation | None],
) -> Judgement:
    """Return what is to be said of a model as it is."""
    top = ranked[0] if ranked else None
    if top is None or not top.claimed:
        return _without_claim(baseline, ranked, faulty, foretell)
    best = top.candidate
    if best.term.effect.kind == "physics" and top.evidence < _DECISIVE and faulty:
        return Judgement("sensor_fault", ranked, baseline.fit, corrected=True)
    if baseline.adequate(best.fit):
        if not best.plausible:
            shape = free_form(baseline, baseline.fit)
            return Judgement("unknown_effect", ranked, best.fit, shape=shape)
        alone = Judgement(verdict_of(best), ranked, best.fit)
        return alone if baseline.floor_is_sure else if_foretold(baseline, alone, foretell())
    return _beyond_one(baseline, ranked, library, foretell)


def _without_claim(
    baseline: Baseline,
    ranked: tuple[Ranked, ...],
    faulty: bool,
    foretell: Callable[[], Confirmation | None],
) -> Judgement:
    if not baseline.adequate(baseline.fit):
        return by_curves(baseline, ranked, foretell(), baseline.fit)
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

    Of many releases a few are searched, and all judge what was found. More than one effect is fitted to chi-square only
    where the floor is sure: two follow any guess of it.
    """
    best = ranked[0].candidate
    if not baseline.floor_is_sure:
        return by_curves(baseline, ranked, foretell(), best.fit)
    few = FewReleases.of(baseline, tuple(entry.candidate for entry in ranked))
    alike = _by_family(few, ranked)
    if alike is not None:
        return alike
    two = next((pair for pair in pairs(few.baseline, few.tried, library) if pair.plausible), None)
    together = None if two is None else Pair(two.first, few.candidate_on_all(two.second))
    if together is not None and together.second.score >= best.score:
        together = None
    if together is not None and baseline.adequate(together.second.fit):
        return _of_pair(ranked, together, None)
    three = triple(few.baseline, library, few.tried[0].fit if two is None else two.second.fit)
    whole = None if three is None else few.on_all(three.fit)
    if three is not None and whole is not None and baseline.adequate(whole):
        return _of_three(ranked, replace(three, fit=whole))
    final = best.fit if together is None else together.second.fit
    return by_curves(baseline, ranked, foretell(), final)


def _of_pair(ranked: tuple[Ranked, ...], pair: Pair, shape: NonparametricForce | None) -> Judgement:
    """Return the judgement that names a pair, the one that is better alone first."""
    names = (pair.first.name, pair.second.name)
    first = next(entry for entry in ranked if entry.candidate.name in names)
    rest = tuple(entry for entry in ranked if entry is not first)
    other = tuple(name for name in names if name != first.candidate.name)
    return Judgement(verdict_of(first.candidate), (first, *rest), pair.second.fit, other, shape)


def _of_three(ranked: tuple[Ranked, ...], three: Triple) -> Judgement:
    """Return the judgement that names three effects, the one that is best alone first."""
    first = next(entry for entry in ranked if entry.candidate.name in three.names)
    rest = tuple(entry for entry in ranked if entry is not first)
    others = tuple(name for name in three.names if name != first.candidate.name)
    return Judgement(verdict_of(first.candidate), (first, *rest), three.fit, others)


def _by_family(few: FewReleases, ranked: tuple[Ranked, ...]) -> Judgement | None:
    """Return the judgement of a law with a free exponent that reaches the floor where no named effect does."""
    found = families(few.baseline, few.tried)
    near = next((c for c in found if c.plausible and few.baseline.adequate(c.fit)), None)
    best = None if near is None else few.candidate_on_all(near)
    if best is None or not best.plausible or not few.whole.adequate(best.fit):
        return None
    entry = Ranked(best, 0.5 * best.gain, float("nan"), True)
    return Judgement("missing_effect", (entry, *ranked), best.fit)
