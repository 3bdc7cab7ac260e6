from functools import cache

import pytest
from releases import drawn

from identify.fitting.baseline import fit_baseline
from identify.fitting.harmonic_residual import harmonic_residual
from identify.model.model import base_model


@cache
def asked(effect, strength, seed):
    return harmonic_residual(fit_baseline((drawn(effect, strength, seed)[0],), base_model()).fit)


@pytest.mark.parametrize("seed", [330, 331])
def test_a_model_that_lacks_nothing_leaves_no_more_at_the_harmonics_than_between(seed):
    found = asked(None, 0.0, seed)
    assert found.p_value > 1e-3  # 1 in 1000 of sound records; the bench of regimes has the distribution
    assert 0.4 < found.ratio < 1.9  # some 60 degrees of freedom on either side: 3.5 standard errors
    assert set(found.channels) == {"displacement", "acceleration"}


def test_a_spring_that_stiffens_by_a_thousandth_stands_at_the_harmonics():
    # of the total force 0.1 %, ten times what the noise leaves open: no level of the noise is needed to see it
    found = asked("cubic_stiffness", 0.001, 332)
    assert found.p_value < 1e-12
    assert found.ratio > 5.0


def test_the_same_seed_gives_the_same_answer():
    fit = fit_baseline((drawn(None, 0.0, 330)[0],), base_model()).fit
    assert harmonic_residual(fit, seed=3, draws=60) == harmonic_residual(fit, seed=3, draws=60)
