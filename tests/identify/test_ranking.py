from types import SimpleNamespace

import numpy as np
import pytest
from releases import ready

from identify.diagnosis.ranking import RIVALS_WITHIN, Ranked, line_of_sensor_first, rank
from identify.diagnosis.search import chances, singles
from identify.effects.library import find_effect
from identify.fitting.baseline import ALPHA, fit_baseline
from identify.model.model import Term, base_model
from mocks.generate import draw


def entry(effect, evidence, plausible=True, gain=None):
    term = Term(find_effect(effect), {"channel": "acceleration"} if effect == "mains_hum" else {})
    gain = 2.0 * evidence if gain is None else gain
    return Ranked(SimpleNamespace(term=term, plausible=plausible, gain=gain), evidence, 1e-9, True)


def names(ranked, *, by_gain=False):
    return [one.candidate.term.effect.name for one in line_of_sensor_first(ranked, by_gain=by_gain)]


def test_hum_comes_before_a_force_that_explains_no_more():
    near = (
        entry("second_mass", 50.0),
        entry("cubic_stiffness", 49.0),
        entry("mains_hum", 50.5 - RIVALS_WITHIN),
    )
    assert names(near) == ["mains_hum", "second_mass", "cubic_stiffness"]


def test_hum_that_leaves_as_little_comes_first_where_no_rest_denies_it():
    found = (entry("second_mass", 50.0), entry("mains_hum", 39.0, gain=101.0))
    assert names(found, by_gain=True)[0] == "mains_hum"
    assert (
        names(found)[0] == "second_mass"
    )  # the rest before the release, which is in the evidence, denies hum


def test_hum_that_explains_clearly_less_or_is_implausible_stays_behind():
    assert names((entry("second_mass", 50.0), entry("mains_hum", 45.0)))[0] == "second_mass"
    assert names((entry("second_mass", 50.0), entry("mains_hum", 49.0, plausible=False)))[0] == "second_mass"


def p_value(seed):
    sample = draw(None, 0.0, seed, seconds=3.0, rate=96.0)
    baseline = fit_baseline((ready(sample.rate, sample.displacement, sample.acceleration),), base_model())
    chance = chances(baseline)
    return min(one.p_value for one in rank(baseline, singles(baseline, chance), chance))


@pytest.mark.slow
def test_p_values_of_the_best_suspect_of_nothing_are_uniform():
    values = np.sort([p_value(seed) for seed in range(71000, 71150)])
    excess = np.max(np.arange(1, len(values) + 1) / len(values) - values)
    # Kolmogorov and Smirnov: uniform p-values exceed this in 1 of 100 samples
    assert excess < 1.52 / np.sqrt(len(values))
    assert np.max(values - np.arange(len(values)) / len(values)) < 1.52 / np.sqrt(len(values))
    assert np.sum(values < 0.02) <= 8  # of 150: 3 expected, more than 8 in 1 of 270 samples
    # Claims of nothing keep the promised 5 %: 7.5 of 150, more than 13 in 1 of 50 samples
    assert np.sum(values < ALPHA) <= 13
