"""The judgement where the noise floor is not reached, or is only a guess.

Chi-square alone names nothing there. An effect is named if it reaches a guessed floor and passes `weighed`, alone or, in
`judgement`, with others; if it predicts what it was not fitted to, and the free run agrees with its strength; or one force
whose simulation leaves almost no residual, where the curves cannot decide. A strength that no curve measures must be clear
of none, but for a second oscillator where the amplitude beats.

A sensor's line beside a force: hum that keeps a force from a floor that could only be guessed.

Hum that stands between the harmonics has nothing to do with the motion, but it fills the misfit that a force must bring
down to the floor. So the residual of the best force is searched for a sensor's line. If there is one, the model gets it, the
noise is estimated again from the residual of both, and all suspects are tried again.
"""

from dataclasses import replace

import numpy as np

from identify.curves.confirm import Curves
from identify.curves.confirmation import Confirmation
from identify.effects.effect import Effect
from identify.effects.families import FAMILY_OF
from identify.evidence import complexity, evidence, nothing
from identify.fitting.baseline import Baseline
from identify.fitting.common_lines import may_be_hum
from identify.fitting.fit import Fit, fit
from identify.fitting.misfit_errors import is_clear, misfit_density
from identify.fitting.model_error import is_negligible, line_percent
from identify.judging.beside_walk import weighed
from identify.judging.nonparametric_force import free_form
from identify.judging.ranking import rank, rivals_of, with_laws_between
from identify.judging.suspects import Candidate, is_predicted, singles, try_terms
from identify.judging.verdict import Judgement
from identify.priors import (
    AGREES,
    DOUBT_AT_A_GUESS,
    LARGE,
    LEAVES,
    NEXT_TO_NOTHING,
    RIVALS_WITHIN,
)

_LINE_LEAVES = 0.5
"""Share of chi-square that a second line may leave where the amplitude beats."""


def at_a_guess(baseline: Baseline, alone: Judgement, curves: Curves) -> Judgement:
    """Judge one effect that reaches a guessed floor.

    A line of a sensor must be worth a name; a smaller one joins the model that is judged, with a remark. The strength
    of a force must differ clearly from zero: a flexible law can fit any assumed noise. Of indistinguishable forces the one
    without a constant of its own leads, else the simplest of such a strength, if it passes `weighed`; a law of time among
    laws of the amplitude names nothing.
    """
    line = alone.ranked[0]
    if line.term.effect.line and not line.term.is_force and line_percent(line.fit, line.term) < LARGE:
        return replace(alone, verdict="nothing_missing", ranked=unclaimed(alone.ranked))
    alike = _alike(baseline, alone.ranked)
    predicted = tuple(entry for entry in alike if is_predicted(entry))[:1]
    of_one_kind = bool(predicted) or len({entry.term.effect.of_time for entry in alike}) == 1
    simplest_first = predicted or sorted(alike, key=lambda entry: complexity(entry.term.effect))
    clear = (e for e in simplest_first if not e.term.is_force or is_clear(e.fit, e.term))
    best = next(clear, None) if of_one_kind else None
    if best is not None:
        rest = tuple(entry for entry in alone.ranked if entry is not best)
        named = replace(alone, ranked=(best, *rest), final=best.fit, confirmation=curves.confirmation)
        kept = named if predicted else weighed(baseline, named)
        if kept.stands:
            return kept
    found = by_curves(baseline, alone.ranked, curves, simplest_first[0].fit)
    return found if best is None else replace(found, decided=kept.decided)


def unclaimed(ranked: tuple[Candidate, ...]) -> tuple[Candidate, ...]:
    """Withdraw the claim of every candidate."""
    return tuple(replace(entry, claimed=False) for entry in ranked)


def _alike(baseline: Baseline, ranked: tuple[Candidate, ...]) -> tuple[Candidate, ...]:
    """List the leader and, if it is a force, the plausible forces at the floor not distinguishable from it, best first.

    Against a guessed floor a few nats mean nothing: the simplest leads, and only another release distinguishes a law of
    time from laws of the amplitude.
    """
    first = ranked[0]
    if not first.term.is_force:
        return (first,)
    names = rivals_of(first, ranked)
    forces = (e for e in ranked[1:] if e.name in names and e.term.is_force)
    reach = (e for e in forces if e.plausible and baseline.adequate(e.fit))
    return (first, *reach)


def by_curves(
    baseline: Baseline, ranked: tuple[Candidate, ...], curves: Curves, best: Fit, *, free_run: bool = True
) -> Judgement:
    """Judge a misfit above the floor: name what the curves confirm, however much of it that explains.

    `best` is the fit that comes closest, named or not. Where the floor is known, half an explanation is not a name, and
    the curves are not asked for one. What they do not confirm may have a name by its `free_run`.
    """
    if curves.driven is not None:
        return Judgement("driven", ranked, baseline.fit, driven=curves.driven)
    found = None if baseline.floor_is_sure else curves.confirmation
    whole = fit_confirmed(baseline, found) if found is not None and found.effects else None
    if found is not None and whole is not None and agree(found, whole):
        return _of_confirmed(baseline, ranked, found, whole)
    single = _by_free_run(baseline, ranked, found, beats=curves.beats) if free_run else None
    if single is not None:
        return single
    if is_negligible(baseline):
        return Judgement("nothing_missing", unclaimed(ranked), baseline.fit, confirmation=found)
    if found is None:
        shape = free_form(baseline, best)
        return Judgement("unknown_effect", ranked, best, shape=shape)
    shape = free_form(baseline, baseline.fit)
    return Judgement("unconfirmed", ranked, baseline.fit, shape=shape, confirmation=found)


def agree(found: Confirmation, whole: Fit) -> bool:
    """Check that curves and free run agree on the strength of each confirmed effect, but for a small factor."""
    strengths = [(whole.values[str(e.term.strength)].value, e.strength) for e in found.effects]
    return all(max(one**2, other**2) < AGREES * one * other for one, other in strengths)


def _of_confirmed(
    baseline: Baseline, ranked: tuple[Candidate, ...], found: Confirmation, whole: Fit
) -> Judgement:
    """Name what the curves confirm, with their evidence; laws of time that are as good in one record are its rivals."""
    own = next((e for e in ranked if found.one_record and (e.name,) == found.names), None)
    drifting = () if own is None else tuple(e for e in _as_good(own, ranked) if e.term.effect.of_time)
    as_good = tuple(e.name for e in drifting)
    effects = (replace(effect, rivals=(*effect.rivals, *as_good)) for effect in found.effects)
    found = replace(found, effects=tuple(effects))
    first = tuple(
        Candidate(effect.term, whole, effect.nats, plausible=True, claimed=True) for effect in found.effects
    )
    rest = tuple(replace(e, claimed=e in drifting) for e in ranked if e.name not in found.names)
    shape = free_form(baseline, whole)
    return Judgement(
        "missing_effect", (*first, *rest), whole, found.names[1:], shape=shape, confirmation=found
    )


def _by_free_run(
    baseline: Baseline, ranked: tuple[Candidate, ...], found: Confirmation | None, *, beats: bool
) -> Judgement | None:
    """Name the one force that the simulation singles out where curves confirm none; None where there is no such force.

    Either the amplitude `beats` and a force without a curve, a second oscillator, leaves least, and much less: a drive that
    begins beats, too, and is a line. Or a force whose strength is clear of none leaves next to nothing of what the model
    left, and no law of time is as good. Of those that are not distinguishable from the best the simplest leads, but first
    one without a constant of its own: it is predicted, and may leave as much as what the curves confirm, if it is as good.
    A line, an oscillator, or a law with a free exponent follows any motion for a while, and keeps no name from such a force.
    """
    much, by_residual = baseline.fit.chi_square, sorted(ranked, key=lambda entry: entry.fit.chi_square)
    forces = [e for e in by_residual if _is_steady_force(e)]
    best = [e for e in by_residual[:1] if e in forces and e.term.force.proportional]
    if beats and best and best[0].fit.chi_square < _LINE_LEAVES * much:
        return _singled_out(baseline, best[0], (), ranked, found)
    laws = [e for e in forces if not e.term.force.proportional and e.term.effect not in FAMILY_OF]
    if baseline.floor_is_sure or not laws:
        return None
    alike = _as_good(laws[0], ranked)
    gravity = (e for e in laws if is_predicted(e))
    shares = ((e, LEAVES**2 if e in alike else NEXT_TO_NOTHING) for e in gravity)
    leader = next((e for e, share in shares if e.fit.chi_square < share * much), None)
    if leader is None and not any(e.term.effect.of_time for e in alike):
        reach = (e for e in laws if e in alike and e.fit.chi_square < NEXT_TO_NOTHING * much)
        leader = min(reach, key=lambda e: complexity(e.term.effect), default=None)
    if leader is None or not is_clear(leader.fit, leader.term):
        return None
    return _singled_out(baseline, leader, alike, ranked, found)


def _singled_out(
    baseline: Baseline,
    leader: Candidate,
    alike: tuple[Candidate, ...],
    ranked: tuple[Candidate, ...],
    found: Confirmation | None,
) -> Judgement:
    """Name a force that the simulation singles out; only it and those `alike` keep their claim."""
    rest = tuple(e if e in alike else replace(e, claimed=False) for e in ranked if e is not leader)
    shape = free_form(baseline, leader.fit)
    return Judgement(
        "missing_effect", (replace(leader, claimed=True), *rest), leader.fit, shape=shape, confirmation=found
    )


def fit_confirmed(baseline: Baseline, found: Confirmation) -> Fit | None:
    """Fit the model with the confirmed effects to all readings, one after the other; None where that only makes it worse."""
    end = baseline.fit
    for effect in found.effects:
        tried = try_terms(baseline.decays, end, (effect.term,))
        if tried:
            end = tried[0].fit
    return end if end.chi_square < baseline.fit.chi_square else None


def line_beside(
    baseline: Baseline, ranked: tuple[Candidate, ...], library: tuple[Effect, ...]
) -> tuple[Candidate, Baseline, tuple[Candidate, ...]] | None:
    """Find a sensor's line beside the best force; return it, the fit with it, and the suspects beside both.

    None where no force is claimed, where one reaches the floor, or where what it leaves holds no line of a sensor.
    """
    force = next((e for e in ranked if _is_steady_force(e)), None)
    if force is None or not force.claimed:
        return None
    if _is_steady_force(ranked[0]) and baseline.adequate(ranked[0].fit):
        return None
    lines = tuple(e for e in library if e.line and e.name not in baseline.fit.model)
    line = _line_behind(replace(baseline, fit=force.fit), lines)
    if line is None:
        return None
    model = baseline.fit.model.plus(line.term)
    begun = line.fit.point | baseline.fit.point
    usual = fit(model, baseline.fit.windows, begun, baseline.fit.frequency, near=True)
    beside = replace(baseline, fit=usual)
    names = {entry.name for entry in ranked} - {line.name}
    tried = tuple(effect for effect in library if effect.name in names)
    return line, beside, with_laws_between(beside, rank(beside, singles(beside, tried)))


def _line_behind(behind: Baseline, lines: tuple[Effect, ...]) -> Candidate | None:
    """Find a sensor's line in the residual of a fit; None where none stands clear of the spectrum around it and lasts.

    None, too, where both channels show it, as shaking is shown.
    """
    found = next((c for c in singles(behind, lines) if c.plausible), None)
    if found is None or found.term.is_force:
        return None
    values = found.fit.of(found.term, 0)
    line = values[next(p.name for p in found.term.effect.parameters if p.unit == "Hz")].value
    if not may_be_hum(behind.fit, found.term.channel, line):
        return None
    density = misfit_density(found.fit, 2.0 * np.pi * line, found.term.channel)
    nats = evidence(behind.fit, found.fit, behind.scales, max(density, 1.0))
    return replace(found, evidence=nats, claimed=True) if nothing([nats]) < DOUBT_AT_A_GUESS else None


def _as_good(one: Candidate, ranked: tuple[Candidate, ...]) -> tuple[Candidate, ...]:
    """List a force, and those that are claimed and not distinguishable from it by their free run, or better."""
    least = one.evidence - RIVALS_WITHIN
    claimed = (e for e in ranked if e is one or (e.claimed and e.evidence > least))
    return tuple(e for e in claimed if _is_steady_force(e))


def _is_steady_force(entry: Candidate) -> bool:
    """Check that a suspect is a plausible force made by the motion: shaking is no better known than a sensor's line."""
    return entry.plausible and entry.term.is_force and not entry.term.effect.line
