"""Chance of a sensor's fault in several releases: what is alike in all, their shared parameters follow."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from bench.regime_cases import Case, release_of
from identify.diagnosis.diagnose import diagnose
from identify.diagnosis.null_faults import drop_by_shares


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (0.6, 1.4)])
def test_the_best_shares_are_those_of_bounded_least_squares(seed, low, high):
    random = np.random.default_rng(seed)
    parts, noise = 3.0 * random.standard_normal((40, 4)), 9.0 * random.standard_normal((40, 6))
    parts[:, 3] = parts[:, 2] + 0.5 * random.standard_normal(40)
    found = drop_by_shares(parts, noise, low, high, 1e-12)
    for drawn, drop in zip(noise.T, found, strict=True):
        best = lsq_linear(parts, drawn, (low, high))
        assert drop == pytest.approx(drawn @ drawn - 2.0 * best.cost, rel=0.01, abs=1e-6)


@pytest.mark.slow
def test_nine_releases_of_nothing_are_no_slow_sensor():
    """Nine fits of one corner make room for it in the spring that they share: chance does so too."""
    case = Case(None, "white", "4 Hz", 9, 880)
    assert diagnose(tuple(release_of(case, k) for k in range(9))).verdict == "nothing_missing"
