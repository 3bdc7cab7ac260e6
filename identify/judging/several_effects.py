"""Several effects at once, where none reaches the floor alone: a law between the names, two effects, or three.

What does not reach the floor on a few releases does not reach it on all, and each trial costs less there. So of many
releases two are searched, on a few cycles, and the result is judged on all.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from identify.effects.effect import Effect
from identify.evidence import evidence
from identify.fitting.baseline import Baseline, residual_lines
from identify.fitting.fit import Fit, fit
from identify.fitting.initial_values import initial_values, scales_of
from identify.fitting.segments import first_cycles
from identify.judging.linear_gain import states_of_term, with_fault
from identify.judging.ranking import DENIED, at_rest
from identify.judging.search import Begun, promising_sets
from identify.judging.suspects import (
    Candidate,
    candidate_terms,
    is_plausible,
    laws_of_free_exponent,
    score_candidate,
    try_terms,
)
from identify.model.model import Term

_CYCLES = 30.0
"""Cycles of each of the two, at most: what a record of a few seconds has."""

_LOOKED_AT, _BEAM = 6, 3
"""Of the best single candidates so many are looked at, and so many get a second effect beside them."""


@dataclass(frozen=True, eq=False)
class FewReleases:
    """The baseline of all releases, `whole`, that of a few of them, and the candidates as refitted to the few.

    `places` are those of the few among all.
    """

    whole: Baseline
    baseline: Baseline
    tried: tuple[Candidate, ...]
    places: tuple[int, ...]

    @classmethod
    def of(cls, whole: Baseline, tried: tuple[Candidate, ...]) -> Self:
        """Take the first cycles of the releases of the largest and the smallest amplitude; all where there are only two."""
        order = sorted(range(len(whole.decays)), key=lambda i: -whole.decays[i].amplitude)
        places = tuple(sorted({order[0], order[-1]}))
        if len(places) == len(whole.decays):
            return cls(whole, whole, tried, places)
        decays = tuple(first_cycles(whole.decays[i], _CYCLES) for i in places)
        windows = tuple(
            whole.fit.windows[i].part(slice(len(prepared.window)))
            for i, prepared in zip(places, decays, strict=True)
        )

        def refitted(found: Fit, goal: float = 0.0) -> Fit:
            start = found.of_windows(places)
            return fit(found.model, windows, start, found.frequency, near=True, goal=goal)

        base = refitted(whole.fit)
        baseline = Baseline(decays, base, tuple(whole.floors[i] for i in places))
        scales = scales_of(decays[0], residual_lines(base))
        goal = baseline.highest * base.degrees
        few = (score_candidate(refitted(c.fit, goal), base, c.term, scales) for c in tried)
        return cls(whole, baseline, tuple(sorted(few, key=lambda c: -c.evidence)), places)

    def on_all(self, found: Fit) -> Fit:
        """Fit a model that was found on the few releases to all of them."""
        if self.baseline is self.whole:
            return found
        base = self.whole.fit
        shared = {u.name: found.values[u.name].value for u in found.unknowns if u.window < 0}
        start = base.point | shared
        for term in (term for term in found.model.terms if term.effect.name not in base.model):
            if term.is_force:
                start |= states_of_term(base, term, start)
            else:
                own = {name: estimate.value for name, estimate in found.of(term, 0).items()}
                start = with_fault(base, term, own) | start
        return fit(found.model, base.windows, start, base.frequency, near=True)


@dataclass(frozen=True, eq=False)
class Several:
    """The effects that together reach the floor, and the fit with them."""

    fit: Fit
    terms: tuple[Term, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The effects' names."""
        return tuple(term.effect.name for term in self.terms)


def several_effects(
    baseline: Baseline, tried: tuple[Candidate, ...], library: tuple[Effect, ...]
) -> Several | None:
    """Find the effects that together explain some releases; None where none do. `tried` are single ones, best first."""
    few = FewReleases.of(baseline, tried)
    for several in _reaching(few.baseline, few.tried, library):
        whole = few.on_all(several.fit)
        if baseline.adequate(whole):
            return replace(several, fit=whole)
    return None


def _reaching(
    baseline: Baseline, tried: tuple[Candidate, ...], library: tuple[Effect, ...]
) -> Iterator[Several]:
    """Yield the sets that reach the floor with plausible values: a law of a free exponent, two effects, or three.

    Forces that explain most together, by equation error, come before what goes with the best single candidates, faults of
    sensors among it.
    """
    goal = baseline.highest * baseline.fit.degrees
    laws = laws_of_free_exponent(baseline, [candidate.name for candidate in tried], goal)
    reaching = (law for law in laws if law.plausible and baseline.adequate(law.fit))
    yield from (Several(law.fit, (law.term,)) for law in reaching)
    largest = baseline.largest
    terms = candidate_terms(baseline.fit.model, library, baseline.fit.windows[0])
    scales = scales_of(largest, residual_lines(baseline.fit))
    pairs, triples = promising_sets(largest, baseline.fit.model, terms, scales)
    yield from _together(baseline, pairs)
    yield from _beside_the_best(baseline, tried, library)
    yield from _together(baseline, triples)


def _together(baseline: Baseline, sets: Sequence[tuple[Begun, ...]]) -> Iterator[Several]:
    """Yield the sets of forces that reach the floor, the most probable first; each is fitted as a whole.

    Where none does, the one that leaves least begins anew from other values before it is given up.
    """
    scales = baseline.scales
    found = [_fitted(baseline, one) for one in sets]
    reaching = [one for one in found if baseline.adequate(one.fit)]
    if found and not reaching:
        closest = min(found, key=lambda one: one.fit.chi_square)
        reaching = [one for one in (_begun_anew(baseline, closest),) if baseline.adequate(one.fit)]
    for one in sorted(reaching, key=lambda one: -evidence(baseline.fit, one.fit, scales)):
        if all(_makes_sense(baseline, one.fit, term) for term in one.terms):
            yield one


def _makes_sense(baseline: Baseline, found: Fit, term: Term) -> bool:
    """Check that each of several effects has plausible values, and that the rest before the releases allows it."""
    scales = baseline.scales
    return is_plausible(found, term, scales) and at_rest(baseline.decays, found, term) > DENIED


def _fitted(baseline: Baseline, together: tuple[Begun, ...]) -> Several:
    model, inner = baseline.fit.model, {name: e.value for name, e in baseline.fit.parameters.items()}
    for begun in together:
        model = model.plus(begun.term)
        inner |= begun.term.by_name(begun.inner)
    start = initial_values(baseline.decays, model, inner)
    goal = baseline.highest * baseline.fit.degrees
    found = fit(model, baseline.fit.windows, start, baseline.fit.frequency, goal=goal)
    return Several(found, tuple(begun.term for begun in together))


def _begun_anew(baseline: Baseline, several: Several) -> Several:
    """Fit some effects again, each in turn from all its starting values, and keep the best fit."""
    found = several.fit
    for term in sorted(several.terms, key=lambda term: -len(term.effect.inner)):
        less = fit(found.model.minus(term.effect.name), found.windows, found.point, found.frequency)
        if not np.isfinite(less.chi_square):
            continue
        again = try_terms(baseline.decays, less, (term,))
        found = min((found, *(c.fit for c in again)), key=lambda one: one.chi_square)
        if baseline.adequate(found):
            break
    return replace(several, fit=found)


def _beside_the_best(
    baseline: Baseline, tried: tuple[Candidate, ...], library: tuple[Effect, ...]
) -> Iterator[Several]:
    """Yield the best single candidates, each with its best partner: a fault beside a force, anything beside a fault."""
    looked_at = sorted(tried[:_LOOKED_AT], key=lambda c: (not c.plausible, -c.evidence))
    for first in looked_at[:_BEAM]:
        terms = candidate_terms(first.fit.model, library, first.fit.windows[0])
        if first.term.is_force:
            terms = tuple(term for term in terms if not term.is_force)
        goal = baseline.highest * first.fit.degrees
        seconds = try_terms(baseline.decays, first.fit, terms, goal=goal)
        second = max(
            (c for c in seconds if at_rest(baseline.decays, c.fit, c.term) > DENIED),
            key=lambda c: c.evidence + at_rest(baseline.decays, c.fit, c.term),
            default=None,
        )
        if second is not None and first.plausible and second.plausible and baseline.adequate(second.fit):
            yield Several(second.fit, (first.term, second.term))
