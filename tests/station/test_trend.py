"""Trends against straight lines that were drawn: the slope, its error, the p-value, outliers, several at once."""

import numpy as np
import pytest

from station.campaign.statistics import find_trend, sure_ones


def test_the_slope_is_that_of_weighted_least_squares():
    x = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    y = np.array([1.0, 3.1, 4.9, 7.2, 8.8])
    std = np.array([0.5, 0.4, 0.5, 0.6, 0.5])
    design = np.column_stack([np.ones(5), x]) / std[:, None]
    covariance = np.linalg.inv(design.T @ design)
    slope = (covariance @ design.T @ (y / std))[1]
    found = find_trend(x, y, std)  # the line fits better than the errors say: no scatter is added
    assert found.slope == pytest.approx(slope, rel=1e-12)
    assert found.std == pytest.approx(np.sqrt(covariance[1, 1]), rel=1e-12)


@pytest.mark.parametrize("scatter", [0.0, 3.0])
def test_the_stated_error_and_p_value_hold_whether_or_not_sessions_scatter_besides(scatter):
    random = np.random.default_rng(5)
    off, p_values = [], []
    for _ in range(400):
        x, std = random.uniform(0, 10, 25), random.uniform(0.5, 2.0, 25)
        noise = std * random.standard_normal(25) + scatter * random.standard_normal(25)
        found = find_trend(x, 7.0 + 0.5 * x + noise, std)
        off.append((found.slope - 0.5) / found.std)
        p_values.append(find_trend(x, noise, std).p_value)
    # 400 draws: the standard deviation is known to 3.5 %, a share of 5 % to 1.1 %.
    assert np.std(off) == pytest.approx(1.04, abs=0.13)
    assert np.mean(np.array(p_values) < 0.05) == pytest.approx(0.05, abs=0.035)


def test_one_session_far_off_neither_hides_nor_makes_a_trend():
    random = np.random.default_rng(6)
    x = np.linspace(0, 1, 30)
    noise = 0.01 * random.standard_normal(30)
    y = 5.0 + 0.1 * x + noise
    y[29] -= 3.0
    found = find_trend(x, y, np.full(30, 0.01))
    assert found.left_out == 1
    assert found.slope == pytest.approx(0.1, abs=4 * found.std)
    assert found.p_value < 1e-6
    flat = noise.copy()
    flat[29] += 3.0
    assert find_trend(x, flat, np.full(30, 0.01)).p_value > 0.01


def test_values_without_errors_weigh_the_same():
    x = np.arange(10.0)
    y = x + np.array([1, -1] * 5) * 0.1
    slope, _ = np.polyfit(x, y, 1)
    assert find_trend(x, y, np.full(10, np.nan)).slope == pytest.approx(slope, rel=1e-9)


@pytest.mark.parametrize(
    ("x", "y"),
    [
        ([1, 2, 3, 4], [1, 2, 3, 5]),
        ([1, 1, 2, 2, 1, 2], [1, 2, 3, 4, 5, 6]),
        ([1, 2, 3, 4, 5, 6], [2, 2, 2, 2, 2, 2]),
        ([1, 2, 3, 4, np.nan, np.nan], [1, 2, 3, 4, 5, 6]),
    ],
)
def test_too_few_sessions_or_places_or_nothing_that_changes_is_no_trend(x, y):
    assert find_trend(np.array(x, float), np.array(y, float), np.full(len(x), 0.1)) is None


@pytest.mark.parametrize(("slope", "start"), [(2.0, 1.0), (0.1, 1.0 / 3.0), (1e-3, 1e6)])
def test_values_that_lie_on_a_line_but_for_rounding_say_nothing_of_its_error(slope, start):
    x = np.arange(8.0)
    assert find_trend(x, slope * x + start, np.full(8, np.nan)) is None


def test_holm_rejects_as_in_its_definition():
    # 0.01 < 0.05/4; 0.015 < 0.05/3; 0.03 > 0.05/2, and with it all that are larger.
    assert sure_ones([0.03, 0.01, 0.04, 0.015]) == [False, True, False, True]
    assert sure_ones([]) == []
