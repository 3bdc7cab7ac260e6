"""A model with the effects that curves confirm, fitted by free run."""

import numpy as np

from identify.curves.confirmation import Confirmation
from identify.diagnosis.suspects import states_of_term
from identify.fitting.baseline import Baseline
from identify.fitting.fit import Fit, fit
from identify.fitting.initial_values import initial_values
from identify.fitting.problem import Problem
from identify.model.model import Model


def fit_confirmed(baseline: Baseline, found: Confirmation) -> Fit | None:
    """Return the model with the confirmed effects, fitted to all readings; None where that only makes it worse.

    It begins from the strengths that the curves give, once with the states of the model as it was and once with those
    of the measured motion; the better end counts. A start that leaves less than the model as it was is not made anew from
    the first cycles, as starts that are far off are: where a second mode beats with the motion, these lead astray.
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
    ends = [
        fit(model, base.windows, start, base.frequency, grow=not _is_closer(model, start, base))
        for start in starts
    ]
    best = min(ends, key=lambda end: end.chi_square)
    return best if best.chi_square < base.chi_square else None


def _is_closer(model: Model, start: dict[str, float], base: Fit) -> bool:
    """Return whether a model leaves less than a fit does, at starting values."""
    problem = Problem(model, base.windows, base.frequency)
    residual = problem.residuals(np.clip(problem.theta(start), problem.low, problem.high))
    return bool(np.isfinite(residual).all() and residual @ residual < base.chi_square)
