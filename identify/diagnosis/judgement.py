"""The judgement: what is claimed, what is not told apart, what is to be said. It is decided here and nowhere else.

Here where the floor is reached or sure; off it in `off_the_floor`. What each candidate's reason is worth: `ranking`.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from identify.curves.confirmation import Confirmation
from identify.diagnosis.few_releases import FewReleases
from identify.diagnosis.free_exponent import families
from identify.diagnosis.nonparametric_force import NonparametricForce
from identify.diagnosis.off_the_floor import by_curves, if_foretold
from identify.diagnosis.ranking import Ranked
from identify.diagnosis.search import Pair, pairs
from identify.diagnosis.suspects import Candidate
from identify.diagnosis.triples import Triple, triple
from identify.diagnosis.verdict import Judgement, free_form, verdict_of
from identify.effects.effect import Effect
from identify.fitting.baseline import Baseline
from identify.fitting.corrected_faults import CorrectedFault
from identify.fitting.fit import Fit

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
    tried = tuple(entry.candidate for entry in ranked)
    few = FewReleases.of(baseline, tried)
    found = _several(few, ranked, library)
    if found.misled:
        found = _several(FewReleases.all(baseline, tried), ranked, library)
    return found.judgement or by_curves(baseline, ranked, foretell(), found.closest)


@dataclass(frozen=True, eq=False)
class _Several:
    """What was found of several effects: the judgement, if one reaches the floor, and the fit that comes closest.

    `misled` where something reaches the floor on the few releases that were searched and not on all.
    """

    judgement: Judgement | None
    closest: Fit
    misled: bool = False


def _several(few: FewReleases, ranked: tuple[Ranked, ...], library: tuple[Effect, ...]) -> _Several:
    """Search a few releases for a law between the names, for two effects and for three; all judge what was found."""
    best, whole = ranked[0].candidate, few.whole
    family = _by_family(few)
    law = None if family is None else few.candidate_on_all(family)
    if law is not None and law.plausible and whole.adequate(law.fit):
        entry = Ranked(law, 0.5 * law.gain, float("nan"), True)
        return _Several(Judgement("missing_effect", (entry, *ranked), law.fit), law.fit)
    two = next((pair for pair in pairs(few.baseline, few.tried, library) if pair.plausible), None)
    second = None if two is None else few.candidate_on_all(two.second)
    better = second is not None and second.score < best.score
    closest = second.fit if second is not None and better else best.fit
    if two is not None and second is not None and better and whole.adequate(second.fit):
        return _Several(_of_pair(ranked, Pair(two.first, second), None), second.fit)
    three = triple(few.baseline, library, few.tried[0].fit if two is None else two.second.fit)
    fit = None if three is None else few.on_all(three.fit)
    if three is not None and fit is not None and whole.adequate(fit):
        return _Several(_of_three(ranked, replace(three, fit=fit)), fit)
    reached = (
        family is not None or three is not None or (two is not None and few.baseline.adequate(two.second.fit))
    )
    return _Several(None, closest, misled=reached and few.baseline is not whole)


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


def _by_family(few: FewReleases) -> Candidate | None:
    """Return a law with a free exponent that reaches the floor of a few releases, where no named effect does."""
    found = families(few.baseline, few.tried)
    return next((c for c in found if c.plausible and few.baseline.adequate(c.fit)), None)
