"""Several effects at once, where none reaches the floor alone: a law between the names, two effects, or three.

Of many releases two are searched, and all judge what was found there.

Three effects at once: the screened triples, each fitted whole, where two of them may not look good without the third.

Many releases: more effects than one are sought on a few of them, on a few cycles, and what is found is fitted to all.

What does not reach the floor on a few releases does not reach it on all, and every trial costs as much less.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from identify.diagnosis.free_exponent import families
from identify.diagnosis.linear_gain import states_of_term
from identify.diagnosis.search import Begun, Pair, pairs, promising_triples
from identify.diagnosis.suspects import Candidate, candidate_terms, residual_lines, score_candidate, try_terms
from identify.effects.effect import Effect
from identify.fitting.baseline import Baseline
from identify.fitting.fit import Fit, fit
from identify.fitting.initial_values import initial_values, scales_of
from identify.fitting.segments import first_cycles
from identify.model.model import Model
from identify.preprocessing.fit_window import FitWindow
from identify.preprocessing.prepared_decay import PreparedDecay

_CYCLES = 30.0
"""Cycles of each of the two, at most: what a record of a few seconds has."""


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
        """Return the first cycles of the releases of the largest and the smallest amplitude; all where there are no more."""
        places = _chosen(whole.decays)
        if len(places) == len(whole.decays):
            return cls.all(whole, tried)
        decays = tuple(first_cycles(whole.decays[i], _CYCLES) for i in places)
        windows = tuple(
            whole.fit.windows[i].until(len(prepared.window))
            for i, prepared in zip(places, decays, strict=True)
        )
        base = _refitted(whole.fit, places, windows)
        baseline = Baseline(decays, base, tuple(whole.floors[i] for i in places))
        scales = scales_of(decays[0], residual_lines(base))
        goal = baseline.highest * base.degrees
        few = tuple(
            score_candidate(_refitted(c.fit, places, windows, goal), base, c.term, scales) for c in tried
        )
        return cls(whole, baseline, tuple(sorted(few, key=lambda c: c.score)), places)

    @classmethod
    def all(cls, whole: Baseline, tried: tuple[Candidate, ...]) -> Self:
        """Return all releases: nothing is searched on fewer."""
        return cls(whole, whole, tried, tuple(range(len(whole.decays))))

    def on_all(self, found: Fit) -> Fit:
        """Return a model that was found on the few, fitted to all releases."""
        if self.baseline is self.whole:
            return found
        base, count = self.whole.fit, len(self.whole.decays)
        start = base.point | {u.name: found.values[u.name].value for u in found.unknowns if u.window < 0}
        start |= _own_linear(base, found)
        for term in found.model.forces:
            if term.effect.name not in base.model:
                start |= states_of_term(base, term, start)
        for i in range(count):
            own = self.places.index(i) if i in self.places else None
            for u in found.unknowns:
                is_theirs = u.window == own or (own is None and u.window == 0 and u.id.role == "parameter")
                if u.window >= 0 and u.deviates < 0 and is_theirs:
                    start[str(u.id.of_release(i, count))] = found.values[u.name].value
        return fit(found.model, base.windows, start, base.frequency, near=True)

    def candidate_on_all(self, found: Candidate) -> Candidate:
        """Return a candidate that was found on the few, fitted to all releases."""
        if self.baseline is self.whole:
            return found
        base = self.whole.fit
        scales = scales_of(self.whole.decays[0], residual_lines(base))
        return score_candidate(self.on_all(found.fit), base, found.term, scales)


def _own_linear(base: Fit, found: Fit) -> dict[str, float]:
    """Return what each release has of its own beside the shared strengths of another fit, to a few of them, by name."""
    own = {
        (found.windows[u.window].release, u.id.parameter): found.values[u.name].value
        for u in found.unknowns
        if u.deviates >= 0
    }
    start = {}
    for u in base.unknowns:
        if u.deviates >= 0:
            shared = base.unknowns[u.deviates].name
            here = base.values[u.name].value + base.values[shared].value - found.values[shared].value
            start[u.name] = own.get((base.windows[u.window].release, u.id.parameter), here)
    return start


def _chosen(decays: tuple[PreparedDecay, ...]) -> tuple[int, ...]:
    """Return the places of the largest and of the smallest amplitude, in the order of the releases."""
    order = sorted(range(len(decays)), key=lambda i: -decays[i].amplitude)
    return tuple(sorted({order[0], order[-1]}))


def _refitted(found: Fit, places: tuple[int, ...], windows: tuple[FitWindow, ...], goal: float = 0.0) -> Fit:
    """Return a fit to all releases refitted to the `windows` of those in `places`.

    Left where it creeps to a `goal` of chi-square above 0.
    """
    return fit(found.model, windows, found.of_windows(places), found.frequency, near=True, goal=goal)


_FITTED = 6

_FAR_LESS = 0.5
"""Share of what two effects leave below which a triple may have missed the floor by its starting values alone."""

_CLEAR = 5.0
"""Standard errors by which the strength of each effect must differ from none: otherwise two of them do."""


@dataclass(frozen=True, eq=False)
class Triple:
    """Three effects by name and the fit of a model with all of them."""

    names: tuple[str, str, str]
    fit: Fit


def triple(baseline: Baseline, library: tuple[Effect, ...], fewer: Fit) -> Triple | None:
    """Return the triple of forces that reaches the floor with the least misfit; None where none of the best does.

    Each must be the best name for what it explains, and needed. `fewer` is the best fit with one or two effects: a triple
    that leaves far less begins anew from other values before it is given up.
    """
    largest = max(baseline.decays, key=lambda prepared: prepared.amplitude)
    terms = candidate_terms(baseline.fit.model, library, baseline.fit.windows[0])
    scales = scales_of(largest, residual_lines(baseline.fit))
    screened = promising_triples(largest, baseline.fit.model, terms, scales)[:_FITTED]
    fits = [_fitted(baseline, three) for three in screened]
    tried = sorted(zip(screened, fits, strict=True), key=lambda entry: entry[1].chi_square)
    if tried and not baseline.adequate(tried[0][1]) and tried[0][1].chi_square < _FAR_LESS * fewer.chi_square:
        three, found = tried[0]
        tried = [(three, _begun_anew(baseline, three, found))]
    for three, found in tried:
        if baseline.adequate(found) and all(_is_needed(baseline, found, begun) for begun in three):
            return Triple((three[0].name, three[1].name, three[2].name), found)
    return None


def _fitted(baseline: Baseline, three: tuple[Begun, Begun, Begun]) -> Fit:
    model, inner = baseline.fit.model, {name: e.value for name, e in baseline.fit.parameters.items()}
    for begun in three:
        model = model.plus(begun.term)
        inner |= begun.term.by_name(begun.inner)
    start = initial_values(baseline.decays, model, inner)
    goal = baseline.highest * baseline.fit.degrees
    return fit(model, baseline.fit.windows, start, baseline.fit.frequency, goal=goal)


def _begun_anew(baseline: Baseline, three: tuple[Begun, Begun, Begun], found: Fit) -> Fit:
    """Return the best fit of a triple of which one effect after the other begins from all its starting values."""
    for begun in sorted(three, key=lambda begun: -len(begun.term.effect.inner)):
        others = Model(tuple(t for t in found.model.terms if t.effect.name != begun.name))
        two = fit(others, found.windows, found.point, found.frequency)
        again = try_terms(baseline.decays, two, (begun.term,))
        found = min((found, *(c.fit for c in again)), key=lambda one: one.chi_square)
        if baseline.adequate(found):
            break
    return found


def _is_needed(baseline: Baseline, found: Fit, begun: Begun) -> bool:
    """Whether an effect of a fit is the best name for what it explains, and of a strength that is clearly not none."""
    scales = scales_of(baseline.decays[0], residual_lines(baseline.fit))
    strength = found.of(begun.term)[begun.term.effect.strength.name]
    clear = np.isfinite(strength.std) and abs(strength.value) > _CLEAR * strength.std
    return bool(clear) and score_candidate(found, baseline.fit, begun.term, scales).plausible


@dataclass(frozen=True, eq=False)
class Several:
    """What reaches the floor, one of `law`, `pair` and `triple` at most, and the fit that comes `closest` to it."""

    closest: Fit
    law: Candidate | None = None
    pair: Pair | None = None
    triple: Triple | None = None

    @property
    def reaches_floor(self) -> bool:
        """Whether anything was found that explains all."""
        return self.law is not None or self.pair is not None or self.triple is not None


def several_effects(baseline: Baseline, tried: tuple[Candidate, ...], library: tuple[Effect, ...]) -> Several:
    """Return what explains some releases together with other effects; `tried` are the single ones as fitted, best first.

    Where two of many releases mislead (what reaches the floor there does not on all), all are searched.
    """
    few = FewReleases.of(baseline, tried)
    found, of_few = _search(few, tried[0], library)
    misled = of_few and not found.reaches_floor and few.baseline is not baseline
    return _search(FewReleases.all(baseline, tried), tried[0], library)[0] if misled else found


def _search(few: FewReleases, best: Candidate, library: tuple[Effect, ...]) -> tuple[Several, bool]:
    """Return what reaches the floor of all releases, and whether anything reaches that of the few.

    `best` is the best single effect, of all releases.
    """
    whole = few.whole
    family = _law(few)
    law = None if family is None else few.candidate_on_all(family)
    if law is not None and law.plausible and whole.adequate(law.fit):
        return Several(law.fit, law=law), True
    closest, closest_of_few, of_few = best.fit, few.tried[0].fit, family is not None
    two = next((pair for pair in pairs(few.baseline, few.tried, library) if pair.plausible), None)
    if two is not None:
        of_few |= few.baseline.adequate(two.second.fit)
        closest_of_few = two.second.fit
        second = few.candidate_on_all(two.second)
        if second.score < best.score:
            closest = second.fit
            if whole.adequate(closest):
                return Several(closest, pair=Pair(two.first, second)), True
    three = triple(few.baseline, library, closest_of_few)
    if three is not None:
        of_few = True
        three = replace(three, fit=few.on_all(three.fit))
        if whole.adequate(three.fit):
            return Several(three.fit, triple=three), True
    return Several(closest), of_few


def _law(few: FewReleases) -> Candidate | None:
    """Return a law with a free exponent that reaches the floor of a few releases, where no named effect does."""
    found = families(few.baseline, few.tried)
    return next((c for c in found if c.plausible and few.baseline.adequate(c.fit)), None)
