from dataclasses import replace

import numpy as np
import pytest
from releases import drawn

from identify.effects.library import find_effect
from identify.evidence import _cost, evidence, nothing
from identify.fitting.baseline import fit_baseline
from identify.fitting.fit import fit
from identify.fitting.initial_values import scales_of
from identify.model.model import Term, base_model
from identify.priors import STRENGTHS


def fitted(name, strength, seed):
    """Return the fits without and with an effect, its term and the sizes of the record."""
    prepared, _ = drawn(name, strength, seed)
    baseline = fit_baseline((prepared,), base_model())
    effect = find_effect(name)
    term = Term(effect, effect.variants[0])
    found = fit(
        base_model().plus(term),
        baseline.fit.windows,
        baseline.fit.point | {str(term.strength): 1.0},
        baseline.fit.frequency,
        near=True,
    )
    return baseline.fit, found, term, scales_of(prepared, {})


@pytest.mark.parametrize("strength", [3e-4, 3e-3])
def test_the_evidence_of_one_strength_is_the_integral_over_all_strengths(strength):
    base, found, term, scales = fitted("cubic_stiffness", strength, 610)
    k3 = found.parameters[str(term.strength)]
    # its likelihood over that of no strength, a parabola; its prior, either sign, even in the logarithm
    sizes = np.abs(k3.value) * np.geomspace(1e-4, 1e4, 200_001)
    both = np.concatenate([-sizes[::-1], sizes])
    gain = 0.5 * (base.chi_square - found.chi_square) - 0.5 * ((both - k3.value) / k3.std) ** 2
    density = 1.0 / (2.0 * np.log(STRENGTHS[-1] / STRENGTHS[0]) * np.abs(both))
    near = np.abs(both) > 0.05 * np.abs(k3.value)  # what is next to none is the model without it
    whole = np.log(np.trapezoid(np.where(near, density * np.exp(gain - gain.max()), 0.0), both)) + gain.max()
    assert evidence(base, found, scales) == pytest.approx(whole, abs=0.5)


def test_the_same_gain_counts_for_less_where_more_was_searched():
    base, found, _, scales = fitted("end_stop", 3e-3, 611)
    free = evidence(base, found, scales)
    place = found.names.index("end_stop.gap")
    others = [j for j in range(len(found.names)) if j != place]
    less = replace(
        found,
        unknowns=tuple(found.unknowns[j] for j in others),
        theta=found.theta[others],
        covariance=found.covariance[np.ix_(others, others)],
    )
    assert evidence(base, less, scales) > free


def test_a_misfit_that_nothing_explains_weakens_the_evidence():
    base, found, _, scales = fitted("cubic_stiffness", 3e-3, 612)
    assert evidence(base, found, scales, 10.0) < 0.2 * evidence(base, found, scales)


def test_none_is_as_probable_as_all_together_to_begin_with():
    assert nothing([]) == 1.0
    assert nothing([0.0, 0.0, 0.0]) == pytest.approx(0.5)
    assert nothing([1e4, -50.0]) == 0.0
    assert nothing([np.log(99.0)]) == pytest.approx(0.01)


@pytest.mark.parametrize("unknown", [1e3, 1e16, np.inf])
def test_what_the_readings_do_not_determine_costs_nothing(unknown):
    known = _cost(np.array([[1e-8]]), np.array([1.0]))
    both = _cost(np.diag([1e-8, unknown]), np.array([1.0, 1.0]))
    assert known == pytest.approx(0.5 * np.log(1e8 / (2.0 * np.pi)), abs=1e-6)
    assert both == pytest.approx(known, abs=1e-3)
