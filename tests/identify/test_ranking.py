import numpy as np
import pytest
from releases import ready

from identify.diagnosis.ranking import rank
from identify.diagnosis.search import chances, singles
from identify.fitting.baseline import ALPHA, fit_baseline
from identify.model.model import base_model
from mocks.generate import draw


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
