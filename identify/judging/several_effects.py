"""Several effects at once, where none reaches the floor alone: two, or three.

What does not reach the floor on a few releases does not reach it on all, and each trial costs less there. So of many
releases two are searched, on a few cycles, and the result is judged on all.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Self

from identify.effects.effect import Effect
from identify.evidence import evidence
from identify.fitting.baseline import Baseline, residual_lines
from identify.fitting.fit import Fit, fit, fit_at
from identify.fitting.initial_values import initial_values, scales_of
from identify.fitting.problem import Problem
from identify.fitting.segments import first_cycles
from identify.judging.linear_gain import in_releases, promising_forces, states_of_term, with_fault
from identify.judging.ranking import at_rest, chi_square_unit, weigh_candidate
from identify.judging.search import Begun, promising_sets
from identify.judging.suspects import (
    Candidate,
    InPlace,
    candidate_terms,
    is_plausible,
    is_predicted,
    score_candidate,
    try_terms,
)
from identify.model.model import Term
from identify.priors import RIVALS_WITHIN

_CYCLES = 30.0
"""Cycles of each of the two, at most: what a record of a few seconds has."""

_BEAM = 3
"""Of the best single candidates so many get a second effect beside them."""

_FORCES = 4
"""Forces that are fitted beside one of these where there is one channel, by their linear gain."""

_INSTEAD = 2
"""Effects that are tried in the place of one of several, by what it may be mistaken for."""


@dataclass(frozen=True, eq=False)
class FewReleases:
    """The `baseline` of a few releases, at some `places` among those of the baseline of all, `whole`."""

    whole: Baseline
    baseline: Baseline
    places: tuple[int, ...]

    @classmethod
    def of(cls, whole: Baseline) -> Self:
        """Take the first cycles of the releases of the largest and the smallest amplitude; all where there are only two."""
        order = sorted(range(len(whole.decays)), key=lambda i: -whole.decays[i].amplitude)
        places = tuple(sorted({order[0], order[-1]}))
        if len(places) == len(whole.decays):
            return cls(whole, whole, places)
        decays = tuple(first_cycles(whole.decays[i], _CYCLES) for i in places)
        windows = tuple(
            whole.fit.windows[i].part(slice(len(prepared.window)))
            for i, prepared in zip(places, decays, strict=True)
        )
        start = whole.fit.of_windows(places)
        base = fit(whole.fit.model, windows, start, whole.fit.frequency, near=True)
        return cls(whole, Baseline(decays, base, tuple(whole.floors[i] for i in places)), places)

    def on_few(self, found: Fit) -> Fit:
        """Fit a model that was found on all releases to the few."""
        if self.baseline is self.whole:
            return found
        windows, start = self.baseline.fit.windows, found.of_windows(self.places)
        return fit(found.model, windows, start, found.frequency, near=True)

    def on_all(self, found: Fit) -> Fit:
        """Fit a model that was found on the few releases to all of them."""
        if self.baseline is self.whole:
            return found
        base = self.whole.fit
        shared = {u.name: found.values[u.name].value for u in found.unknowns if u.window < 0}
        start = base.point | shared
        for term in (term for term in found.model.terms if term.effect.name not in base.model):
            own = {name: estimate.value for name, estimate in found.of(term, 0).items()}
            if term.is_force:
                start |= in_releases(base, term, own, self.places[0]) | states_of_term(base, term, start)
            else:
                start = with_fault(base, term, own) | start
        return fit(found.model, base.windows, start, base.frequency, near=True)


@dataclass(frozen=True, eq=False)
class Several:
    """The effects that together reach the floor, the fit with them, and the `places` of two or more."""

    fit: Fit
    terms: tuple[Term, ...]
    places: tuple[InPlace, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """The effects' names."""
        return tuple(term.effect.name for term in self.terms)


def several_effects(
    baseline: Baseline, tried: tuple[Candidate, ...], library: tuple[Effect, ...]
) -> Several | None:
    """Find the effects that together explain some releases; None where none do. `tried` are single ones, best first.

    On a few of the releases and on all of them they must reach the floor, with plausible values.
    """
    few = FewReleases.of(baseline)
    found = next(_that_explain(few, baseline, _in_order(few, tried, library)), None)
    return None if found is None else _with_places(baseline, found, library)


def pair_instead(
    baseline: Baseline, tried: tuple[Candidate, ...], library: tuple[Effect, ...]
) -> Several | None:
    """Find two forces of one constant each that are more probable than the first of single ones; None where none are.

    They cost no more than one with several constants of its own; one with a single constant is not questioned.
    """
    law = tried[0]
    if law.term.effect.line or len(law.term.free) < 2:
        return None
    few = FewReleases.of(baseline)
    least = weigh_candidate(baseline, baseline.fit, law, 1.0).evidence + RIVALS_WITHIN
    for whole in _that_explain(few, baseline, _simple_pairs(few, tried, library)):
        if evidence(baseline.fit, whole.fit, baseline.scales) > least:
            return _with_places(baseline, whole, library)
    return None


def _that_explain(few: FewReleases, baseline: Baseline, sets: Iterable[Several]) -> Iterator[Several]:
    """Yield the sets that explain the few releases, and then all, fitted to all."""
    for several in sets:
        if _explains(few.baseline, several):
            whole = replace(several, fit=few.on_all(several.fit))
            if _explains(baseline, whole):
                yield whole


def _with_places(
    baseline: Baseline, found: Several, library: tuple[Effect, ...], seen: tuple[set[str], ...] = ()
) -> Several:
    """Try what each of several effects may be mistaken for in its place, and nothing; what is more probable takes it.

    At a guessed floor a force without a constant of its own does of what this record does not distinguish.
    """
    if len(found.terms) == 1:
        return found
    unit = chi_square_unit(baseline, (found.fit,))
    places = tuple(_place(baseline, found.fit, term, library, unit) for term in found.terms)

    def standing(one: Candidate) -> float:
        leads = not baseline.floor_is_sure and is_predicted(one)
        return one.evidence + (RIVALS_WITHIN if leads else 0.0)

    for i, place in enumerate(places):
        before, after = found.terms[:i], found.terms[i + 1 :]
        own, *others = place.tried
        instead = [(standing(one), Several(one.fit, (*before, one.term, *after))) for one in others]
        instead.append((0.0, Several(place.without, (*before, *after))))
        better = [
            (nats, one)
            for nats, one in instead
            if nats > standing(own) and set(one.names) not in seen and _explains(baseline, one)
        ]
        if better:
            _, best = max(better, key=lambda one: one[0])
            return _with_places(baseline, best, library, (*seen, set(found.names)))
    return replace(found, places=places)


def _place(baseline: Baseline, found: Fit, term: Term, library: tuple[Effect, ...], unit: float) -> InPlace:
    own = term.effect
    model = found.model.minus(own.name)
    less = fit(model, found.windows, found.point, found.frequency)
    problem = Problem(model, found.windows, found.frequency)
    beside = fit_at(problem, problem.theta(found.point))
    known = {effect.name: effect for effect in library if effect.name not in found.model}
    others = [known[name] for name in own.confusable_with if name in known]
    terms = candidate_terms(less.model, others, less.windows[0])
    first = list(dict.fromkeys(one.effect.name for one in terms))[:_INSTEAD]
    terms = tuple(one for one in terms if one.effect.name in first)
    tried = (score_candidate(found, less, term, baseline.scales), *try_terms(baseline.decays, beside, terms))
    return InPlace(less, tuple(weigh_candidate(baseline, less, one, unit) for one in tried))


def _in_order(
    few: FewReleases, tried: tuple[Candidate, ...], library: tuple[Effect, ...]
) -> Iterator[Several]:
    """Yield the sets to judge, fitted to a few releases: two effects, or three.

    Forces that explain most together, by equation error, come before what goes with the best single candidates, faults of
    sensors among it. One channel is differentiated twice for the equation error, which then misses pairs: there the
    simplest ones come first.
    """
    baseline = few.baseline
    if not baseline.decays[0].window.paired:
        yield from _simple_pairs(few, tried, library)
    largest = baseline.largest
    terms = candidate_terms(baseline.fit.model, library, baseline.fit.windows[0])
    scales = scales_of(largest, baseline.scales.lines)
    pairs, triples = promising_sets(largest, baseline.fit.model, terms, scales)
    yield from _together(baseline, pairs)
    yield from _beside_the_best(few, tried, library)
    yield from _together(baseline, triples)


def _explains(baseline: Baseline, several: Several) -> bool:
    """Check that a fit reaches the floor, each effect with plausible values and allowed by the rest before the releases."""
    return baseline.adequate(several.fit) and all(
        is_plausible(several.fit, term, baseline.scales)
        and at_rest(baseline.decays, several.fit, term) > -RIVALS_WITHIN
        for term in several.terms
    )


def _together(baseline: Baseline, sets: Sequence[tuple[Begun, ...]]) -> Iterator[Several]:
    """Yield sets of forces, each fitted as a whole, the most probable first."""
    found = [_fitted(baseline, one) for one in sets]
    yield from sorted(found, key=lambda one: -evidence(baseline.fit, one.fit, baseline.scales))


def _fitted(baseline: Baseline, together: tuple[Begun, ...]) -> Several:
    model, inner = baseline.fit.model, {name: e.value for name, e in baseline.fit.parameters.items()}
    for begun in together:
        model = model.plus(begun.term)
        inner |= in_releases(baseline.fit, begun.term, begun.inner)
    start = initial_values(baseline.decays, model, inner)
    goal = baseline.highest * baseline.fit.degrees
    found = fit(model, baseline.fit.windows, start, baseline.fit.frequency, goal=goal)
    return Several(found, tuple(begun.term for begun in together))


def _simple_pairs(
    few: FewReleases, tried: tuple[Candidate, ...], library: tuple[Effect, ...]
) -> Iterator[Several]:
    """Yield the best forces of one constant, each beside another such."""
    leaders = tuple(one for one in tried if one.term.is_force and len(one.term.free) == 1)
    return _beside_the_best(few, leaders, tuple(e for e in library if len(e.parameters) == 1))


def _beside_the_best(
    few: FewReleases, tried: tuple[Candidate, ...], library: tuple[Effect, ...]
) -> Iterator[Several]:
    """Yield the best single candidates, each with its best partner: a fault beside a force, anything beside a fault.

    One channel is differentiated twice for the equation error, which then misses pairs: there a force is tried beside a
    force, too, of which the linear gain selects a few.
    """
    baseline = few.baseline
    paired = baseline.decays[0].window.paired
    for first in [candidate for candidate in tried if candidate.plausible][:_BEAM]:
        alone = few.on_few(first.fit)
        terms = candidate_terms(alone.model, library, alone.windows[0])
        if first.term.is_force:
            faults = tuple(term for term in terms if not term.is_force)
            scales = scales_of(baseline.decays[0], residual_lines(alone))
            forces = () if paired else promising_forces(baseline.decays, alone, terms, scales, _FORCES)
            terms = (*forces, *faults)
        seconds = try_terms(baseline.decays, alone, terms, goal=baseline.highest * alone.degrees)
        rest = {one: at_rest(baseline.decays, one.fit, one.term) for one in seconds}
        allowed = [one for one in seconds if rest[one] > -RIVALS_WITHIN]
        if allowed:
            second = max(allowed, key=lambda one: one.evidence + rest[one])
            yield Several(second.fit, (first.term, second.term))
