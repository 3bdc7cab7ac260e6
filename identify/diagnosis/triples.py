"""Three effects at once: the screened triples, each fitted whole, where two of them may not look good without the third."""

from dataclasses import dataclass

import numpy as np

from identify.diagnosis.screening import Begun, promising_triples
from identify.diagnosis.suspects import candidate_terms, residual_lines, score_candidate, try_terms
from identify.effects.effect import Effect
from identify.fitting.baseline import Baseline
from identify.fitting.fit import Fit, fit
from identify.fitting.initial_values import initial_values, scales_of
from identify.model.model import Model

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
