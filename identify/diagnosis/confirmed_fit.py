"""A model with the effects that curves confirm, fitted by free run."""

from identify.curves.confirmation import Confirmation
from identify.diagnosis.suspects import try_terms
from identify.diagnosis.weak_presence import states_of_term
from identify.fitting.baseline import Baseline
from identify.fitting.fit import Fit, fit, is_far
from identify.fitting.initial_values import initial_values
from identify.model.model import Model


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
