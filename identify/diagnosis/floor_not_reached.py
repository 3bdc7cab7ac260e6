"""The judgement off the floor: where it is not reached, or could only be guessed.

Chi-square alone names nothing there. Effects are named that predict what they were not fitted to; or one force whose
free run leaves next to nothing, where the curves cannot say.
"""

from dataclasses import replace

from identify.curves.confirmation import Confirmation
from identify.diagnosis.linear_gain import states_of_term
from identify.diagnosis.nonparametric_force import free_form
from identify.diagnosis.ranking import Ranked, rivals_of
from identify.diagnosis.suspects import Candidate, try_terms
from identify.diagnosis.verdict import Judgement
from identify.effects.force_effect import ForceEffect
from identify.evidence.evidence import complexity
from identify.fitting.baseline import Baseline
from identify.fitting.fit import Fit, fit, is_far
from identify.fitting.initial_values import initial_values
from identify.fitting.misfit_errors import is_clear
from identify.fitting.model_error import line_percent, motion_percent
from identify.model.model import Model
from identify.priors import LARGE, MOST_ALIKE, NEGLIGIBLE, NEXT_TO_NOTHING

_NEXT_LEAVES = 3.0
"""A force that leaves less than this many times as much is not told apart from it."""

_THE_SAME = 0.05
"""Relative difference up to which a strength is the one predicted: one in thirty of those between -1 and 2 times it."""

_LINE_LEAVES = 0.5
"""Share of chi-square that a second line may leave where the amplitude beats."""


def at_a_guess(baseline: Baseline, alone: Judgement, found: Confirmation | None) -> Judgement:
    """Return the judgement of one effect that reaches a guessed floor.

    A line of a sensor must be worth a name; a smaller one is part of the model that is judged, and a remark. The strength
    of a force must be clear of none: what bends enough reaches any guess. Of forces that are not told from it the one
    without a constant of its own leads, else the simplest; a law of time among laws of the amplitude names nothing.
    """
    line = alone.ranked[0].candidate
    if line.term.effect.line and not line.term.is_force and line_percent(line.fit, line.term) < LARGE:
        return replace(alone, verdict="nothing_missing", ranked=unclaimed(alone.ranked))
    alike = _alike(baseline, alone.ranked)
    predicted = next((entry for entry in alike if is_predicted(entry.candidate)), None)
    lead = predicted or min(alike, key=lambda entry: complexity(entry.candidate.term.effect))
    best = lead.candidate
    of_one_kind = predicted is not None or len({entry.candidate.term.effect.of_time for entry in alike}) == 1
    clear = best.term.effect.kind != "physics" or is_clear(best.fit, best.term, predicted=False)
    if not (of_one_kind and clear):
        return by_curves(baseline, alone.ranked, found, best.fit)
    rest = tuple(entry for entry in alone.ranked if entry is not lead)
    return replace(alone, ranked=(lead, *rest), final=best.fit, confirmation=found)


def unclaimed(ranked: tuple[Ranked, ...]) -> tuple[Ranked, ...]:
    """Return the candidates, none of them claimed."""
    return tuple(replace(entry, claimed=False) for entry in ranked)


def _alike(baseline: Baseline, ranked: tuple[Ranked, ...]) -> tuple[Ranked, ...]:
    """Return the leader and, of a force, the plausible forces at the floor that are not told from it, best first.

    Against a guess of the floor a few nats say nothing: of these the simplest leads, and a law of time among laws of the
    amplitude is told from them by another release only.
    """
    first = ranked[0]
    if not first.candidate.term.is_force:
        return (first,)
    names = rivals_of(first, ranked)
    forces = (e for e in ranked[1:] if e.candidate.name in names and e.candidate.term.is_force)
    reach = (e for e in forces if e.candidate.plausible and baseline.adequate(e.candidate.fit))
    return (first, *reach)


def by_curves(
    baseline: Baseline, ranked: tuple[Ranked, ...], found: Confirmation | None, best: Fit
) -> Judgement:
    """Return the judgement of a misfit above the floor: what the curves confirm, however much of it that explains.

    `best` is the fit that comes closest, named or not.
    """
    if found is not None and found.driven:
        return Judgement("driven", ranked, baseline.fit, confirmation=found)
    whole = None if found is None else _worthy(baseline, found)
    if found is not None and whole is not None:
        return _of_confirmed(baseline, ranked, found, whole)
    contradicted = found is not None and bool(found.effects)
    alone = None if contradicted else _by_free_run(baseline, ranked, found)
    if alone is not None:
        return alone
    if not baseline.floor_is_sure and motion_percent(baseline.fit) < NEGLIGIBLE:
        return Judgement("nothing_missing", unclaimed(ranked), baseline.fit, confirmation=found)
    if found is None or baseline.floor_is_sure:
        shape = free_form(baseline, ranked[0].candidate.fit if best is not baseline.fit else best)
        return Judgement("unknown_effect", ranked, best, shape=shape, confirmation=found)
    shape = free_form(baseline, baseline.fit)
    return Judgement("unconfirmed", ranked, baseline.fit, shape=shape, confirmation=found)


def _worthy(baseline: Baseline, found: Confirmation) -> Fit | None:
    """Return the fit with what curves confirm; None where that is nothing, or its free run does not bear it out.

    One strength at least must be clear of none. Where the floor is known, half an explanation is not a name.
    """
    whole = fit_confirmed(baseline, found) if found.effects else None
    if whole is None or not any(is_clear(whole, e.term, predicted=True) for e in found.effects):
        return None
    left = whole.chi_square / baseline.fit.chi_square
    return None if baseline.floor_is_sure and left > NEXT_TO_NOTHING else whole


def _of_confirmed(
    baseline: Baseline, ranked: tuple[Ranked, ...], found: Confirmation, whole: Fit
) -> Judgement:
    """Return the judgement that names what curves confirm, with their evidence."""
    gain = baseline.fit.chi_square - whole.chi_square
    first = tuple(
        Ranked(Candidate(effect.term, whole, whole.chi_square, gain, True), effect.nats, True)
        for effect in found.effects
    )
    rest = tuple(replace(e, claimed=False) for e in ranked if e.candidate.name not in found.names)
    shape = free_form(baseline, whole)
    return Judgement(
        "missing_effect", (*first, *rest), whole, found.names[1:], shape=shape, confirmation=found
    )


def _by_free_run(
    baseline: Baseline, ranked: tuple[Ranked, ...], found: Confirmation | None
) -> Judgement | None:
    """Return the judgement of one force that the free run singles out where curves confirm none, if there is one.

    Either the amplitude beats and a force without a curve, a second oscillator, leaves much less than any other; or
    one leaves next to nothing of what the model left, and far less than all but a few others,
    among which no law of time, and whose strength is clear of none.
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
    predicted = next((entry for entry in near if is_predicted(entry.candidate)), None)
    best = first if beats else predicted or simplest
    left = _misfit(best) / baseline.fit.chi_square
    drifts = any(entry.candidate.term.effect.of_time for entry in near)
    apart = len(near) <= MOST_ALIKE and (predicted is not None or not drifts)
    if not (beats or (left < NEXT_TO_NOTHING and apart and not baseline.floor_is_sure)):
        return None
    clear = is_clear(best.candidate.fit, best.candidate.term, predicted=False)
    if not beats and not clear:  # a mode that hardly moves the first
        return None
    rest = tuple(replace(entry, claimed=False) for entry in ranked if entry is not best)
    final = best.candidate.fit
    shape = free_form(baseline, final)
    rivals = () if beats else tuple(entry.candidate.name for entry in near if entry is not best)
    return Judgement(
        "missing_effect",
        (replace(best, claimed=True, alike=rivals), *rest),
        final,
        shape=shape,
        confirmation=found,
    )


def is_predicted(candidate: Candidate) -> bool:
    """Whether a force has the very strength that the linear part it makes alone has: it has no constant of its own then.

    A law with constants to spare, a drift among them, must leave a third of what such a force leaves to be told from it.
    """
    effect = candidate.term.effect
    part = effect.may_be_all_of if isinstance(effect, ForceEffect) else None
    name = None if part is None else candidate.fit.model.linear_strength(part)
    if name is None:
        return False
    values = candidate.fit.parameters
    whole = values[str(name)].value
    return abs(values[str(candidate.term.strength)].value - whole) < _THE_SAME * whole


def _misfit(entry: Ranked) -> float:
    return entry.candidate.fit.chi_square


def fit_confirmed(baseline: Baseline, found: Confirmation) -> Fit | None:
    """Return the model with the confirmed effects, fitted to all readings; None where that only makes it worse.

    It begins from the strengths that the curves give, once with the states of the model as it was and once with those
    of the measured motion, and with the effects one after the other; the best end counts.
    """
    base = baseline.fit
    model = base.model
    strengths: dict[str, float] = {}
    states: dict[str, float] = {}
    for effect in found.effects:
        model = model.plus(effect.term)
        strengths |= effect.values
        states |= states_of_term(base, effect.term, base.point | effect.values)
    linear = found.linear_strengths
    starts = (
        base.point | linear | strengths | states,
        initial_values(baseline.decays, model, base.point | strengths) | linear | strengths,
    )
    ends = [end for start in starts for end in _ends(base, model, start)]
    ends.append(_one_after_the_other(baseline, found))
    best = min(ends, key=lambda end: end.chi_square)
    return best if best.chi_square < base.chi_square else None


def _ends(base: Fit, model: Model, start: dict[str, float]) -> list[Fit]:
    """Return the fits from a start that may be far off, grown from its first few cycles, and from the start as it is."""
    near = fit(model, base.windows, start, base.frequency, near=True)
    if not is_far(model, base.windows, start, base.frequency):
        return [near]
    return [fit(model, base.windows, start, base.frequency), near]


def _one_after_the_other(baseline: Baseline, found: Confirmation) -> Fit:
    """Return the fit to which each confirmed effect is added in turn, from all its starting values."""
    end = baseline.fit
    for effect in found.effects:
        tried = try_terms(baseline.decays, end, (effect.term,))
        if tried:
            end = tried[0].fit
    return end
