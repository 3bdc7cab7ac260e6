"""The individuals chart: its limits on a normal series, an outlier, a drift, readings that repeat."""

import numpy as np
import pytest

from station.campaign.statistics import control_limits


def test_three_spreads_leave_out_as_many_of_a_normal_series_as_they_should():
    values = 5.0 + 0.2 * np.random.default_rng(1).standard_normal(20_000)
    centre, spread, outside = control_limits(values)
    assert centre == pytest.approx(5.0, abs=0.01)
    assert spread == pytest.approx(0.2, rel=0.03)
    assert outside.mean() == pytest.approx(0.0027, abs=0.0015)


def test_an_outlier_is_outside_and_moves_neither_centre_nor_spread():
    values = np.random.default_rng(2).standard_normal(200)
    before = control_limits(values)
    values[50] = 40.0
    centre, spread, outside = control_limits(values)
    assert outside[50]
    assert centre == pytest.approx(before[0], abs=0.05)
    assert spread == pytest.approx(before[1], rel=0.05)


def test_a_drift_leaves_the_limits_instead_of_widening_them():
    values = np.linspace(0.0, 20.0, 400) + np.random.default_rng(3).standard_normal(400)
    _, spread, outside = control_limits(values)
    assert spread == pytest.approx(1.0, rel=0.2)
    assert outside[:50].mean() > 0.9
    assert outside[-50:].mean() > 0.9


def test_of_readings_that_repeat_only_the_other_one_is_outside():
    *_, outside = control_limits(np.array([2.0] * 9 + [2.5]))
    assert outside.tolist() == [False] * 9 + [True]


def test_four_sessions_have_no_limits():
    assert control_limits(np.arange(4.0)) is None
