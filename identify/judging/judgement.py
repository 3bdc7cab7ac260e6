"""The judgement: what is claimed, what is not distinguishable, and the verdict. Nothing else decides these.

This module judges where the floor is sure; `floor_not_reached` where it is a guess. `ranking` weighs each candidate.
"""

from dataclasses import replace

from identify.curves.confirm import Curves
from identify.effects.effect import Effect
from identify.fitting.baseline import Baseline
from identify.fitting.corrected_faults import CorrectedFault, unnamed_faults
from identify.fitting.model_error import motion_percent, removed_percent
from identify.judging.beside_walk import named_with_walk, weighed, with_walk
from identify.judging.floor_not_reached import at_a_guess, by_curves, line_beside, unclaimed
from identify.judging.nonparametric_force import free_form
from identify.judging.ranking import rank, rivals_of
from identify.judging.several_effects import Several, pair_instead, several_effects
from identify.judging.suspect import Suspect
from identify.judging.suspects import Candidate, score_candidate, try_terms
from identify.judging.verdict import Judgement, verdict_of


def judge(
    baseline: Baseline,
    ranked: tuple[Candidate, ...],
    faults: tuple[CorrectedFault, ...],
    library: tuple[Effect, ...],
    curves: Curves,
) -> Judgement:
    """Decide the verdict: nothing is missing, one effect reaches the floor, several do together, or no name does.

    Where the floor could only be guessed and nothing reaches it, what the `curves` of the decay confirm decides. There the
    fit also allows for a sensor's line beside a force.
    """
    beside = None if baseline.floor_is_sure else line_beside(baseline, ranked, library)
    if beside is not None:
        line, with_line, others = beside
        judged = _judged(with_line, others, library, curves)
        alone = ranked[0].fit
        as_good = baseline.adequate(alone) and alone.reduced <= judged.final.reduced
        if judged.verdict == "missing_effect" and not as_good:  # two are not preferred to a better one
            first, *rest = judged.ranked
            return replace(judged, ranked=(first, line, *rest), together=(*judged.together, line.name))
    judged = _judged(baseline, ranked, library, curves)
    faulty = any(fault.p_value < baseline.alpha for fault in faults)
    if judged.verdict == "nothing_missing" and faulty:  # but a sensor's fault, which every fit has corrected
        return replace(judged, verdict="sensor_fault", ranked=unclaimed(judged.ranked))
    return with_walk(baseline, judged)


def large_enough(baseline: Baseline, judgement: Judgement, worth: float) -> Judgement:
    """Withdraw the name of a force that removes less than `worth` % of the motion, even if it is sure.

    What curves confirm removes prediction error, all else misfit of the free run.
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


def _judged(
    baseline: Baseline,
    ranked: tuple[Candidate, ...],
    library: tuple[Effect, ...],
    curves: Curves,
) -> Judgement:
    """Decide the verdict for a fitted model, leaving aside a sensor's line and the faults that every fit corrects.

    | who reaches the floor | sure floor | guessed floor |
    |---|---|---|
    | the model, and nothing that makes sense is claimed | nothing is missing | the same |
    | the best claim, with values that make sense | it is named, if it passes `weighed` | `at_a_guess`, or two simpler |
    | the best claim, with other values | no name | the same |
    | several effects together | they are named, if each passes `weighed` | the same; else `by_curves` |
    | none | the best claim is named, if it passes `weighed`, or one with a walk; else `by_curves` | `by_curves` |
    """
    best = ranked[0] if ranked and ranked[0].claimed else None
    if (best is None or not best.plausible) and baseline.adequate(baseline.fit):
        return Judgement("nothing_missing", ranked, baseline.fit)
    if best is None:
        return by_curves(baseline, ranked, curves, baseline.fit)
    reached, kept = baseline.adequate(best.fit), None
    if baseline.floor_is_sure:
        kept = _at_a_sure_floor(baseline, ranked, library)
    elif reached and best.plausible:
        alone = at_a_guess(baseline, Judgement(verdict_of(best), ranked, best.fit), curves)
        if alone.verdict == "missing_effect":
            kept = _together(baseline, alone.ranked, pair_instead(baseline, alone.ranked, library))
        if kept is None:
            return alone
    elif not reached and curves.driven is None:
        kept = _together(baseline, ranked, several_effects(baseline, ranked, library))
    if kept is not None and kept.stands:
        return kept
    decided = () if kept is None else kept.decided
    if not reached or (kept is not None and not baseline.floor_is_sure):
        # Where two others are more probable but have no name, a single one has none by its free run either.
        found = by_curves(baseline, ranked, curves, best.fit, free_run=kept is None or not reached)
        return found if found.verdict == "missing_effect" else replace(found, decided=decided)
    shape = free_form(baseline, baseline.fit)
    final = baseline.fit if best.plausible else best.fit
    return Judgement("unknown_effect", ranked, final, shape=shape, decided=decided)


def _at_a_sure_floor(
    baseline: Baseline, ranked: tuple[Candidate, ...], library: tuple[Effect, ...]
) -> Judgement | None:
    """Weigh the best claim, or several effects if it does not reach the floor; None where neither makes sense.

    Of a rig that drifts one effect is named before several.
    """
    best = ranked[0]
    kept = None
    if not baseline.adequate(best.fit):
        kept = _together(baseline, ranked, several_effects(baseline, ranked, library))
    if kept is None and best.plausible:
        kept = weighed(baseline, Judgement(verdict_of(best), ranked, best.fit))
    if kept is not None and kept.stands and kept.walk is None:
        return kept
    return named_with_walk(baseline, ranked) or kept


def _together(baseline: Baseline, ranked: tuple[Candidate, ...], several: Several | None) -> Judgement | None:
    """Weigh several effects that together reach the floor; None where none do."""
    return None if several is None else weighed(baseline, _of_several(baseline, ranked, several))


def _of_several(baseline: Baseline, ranked: tuple[Candidate, ...], found: Several) -> Judgement:
    """Name several effects, the one that is best alone first; what was not tried alone is tried now."""
    if len(found.terms) == 1:
        alone = tuple(score_candidate(found.fit, baseline.fit, term, baseline.scales) for term in found.terms)
        ranked = tuple(entry for entry in ranked if entry.name not in found.names)
    else:
        known = {entry.name for entry in ranked}
        terms = tuple(term for term in found.terms if term.effect.name not in known)
        alone = try_terms(baseline.decays, baseline.fit, terms)
    if alone:
        ranked = rank(baseline, (*alone, *ranked))
    ranked = tuple(replace(entry, claimed=entry.claimed or entry.name in found.names) for entry in ranked)
    first = next(entry for entry in ranked if entry.name in found.names)
    rest = tuple(entry for entry in ranked if entry is not first)
    others = tuple(name for name in found.names if name != first.name)
    return Judgement(verdict_of(first), (first, *rest), found.fit, others, places=found.places)


def listed_suspects(baseline: Baseline, judgement: Judgement, settled: Baseline) -> tuple[Suspect, ...]:
    """List the suspects in order, first those that the verdict names; `settled` is the fit with these."""
    faults = unnamed_faults(baseline.decays, baseline.fit)
    entries = [_suspect(baseline, entry, judgement, settled) for entry in judgement.ranked]
    sensors = sorted(
        (_corrected(baseline, fault, faults) for fault in faults), key=lambda suspect: -suspect.evidence
    )
    return tuple(sorted((*entries, *sensors), key=lambda one: (not one.claimed, one.corrected is not None)))


def _suspect(baseline: Baseline, candidate: Candidate, judgement: Judgement, settled: Baseline) -> Suspect:
    is_final = candidate.fit is judgement.final
    found = candidate.name in judgement.final.model
    told = judgement.confirmation.effects if judgement.confirmation is not None else ()
    confirmed = next((effect for effect in told if effect.name == candidate.name), None)
    alike = judgement.alike(candidate.name)
    if is_final or not found:  # what is as good alone was not tried beside others
        alike = (*alike, *rivals_of(candidate, judgement.ranked))
    if confirmed is not None:
        alike = (*confirmed.rivals, *alike)
    rivals = tuple(dict.fromkeys(alike))
    # Beside others it may be in another variant than alone.
    term = next(
        (one for one in judgement.final.model.terms if one.effect.name == candidate.name), candidate.term
    )
    return Suspect(
        effect=candidate.term.effect,
        term=term,
        error_after=baseline.reduced(candidate.fit),
        motion_after=motion_percent(settled.fit if is_final else candidate.fit),
        evidence=candidate.evidence,
        claimed=candidate.claimed,
        baseline=baseline,
        fit=candidate.fit,
        last=settled.fit if found else candidate.fit,
        rivals=rivals,
        plausible=candidate.plausible,
        confirmed=confirmed,
    )


def _corrected(baseline: Baseline, fault: CorrectedFault, faults: tuple[CorrectedFault, ...]) -> Suspect:
    """Make a suspect of a fault that every fit corrects, with the residual of the model that names it."""
    others = [f for f in faults if f is not fault]
    chi_square = baseline.fit.chi_square + sum(f.drop for f in others)
    return Suspect(
        effect=fault.term.effect,
        term=fault.term,
        error_after=chi_square / max(baseline.fit.degrees + sum(f.readings for f in others), 1),
        motion_after=None,
        evidence=0.5 * fault.surplus,
        claimed=fault.p_value < baseline.alpha,
        baseline=baseline,
        fit=baseline.fit,
        last=baseline.fit,
        corrected=fault.parameters,
    )
