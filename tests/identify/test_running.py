"""Running windows and splines against scipy's, which are too slow to load at every start."""

import numpy as np
import pytest
from scipy import ndimage
from scipy.interpolate import BSpline

from identify.signal.running import running_maximum, running_median, running_minimum
from identify.signal.splines import basis

READINGS = np.random.default_rng(1).normal(size=97)


@pytest.mark.parametrize("width", [1, 2, 3, 7, 8, 9, 64, 96])
def test_extremes_are_those_of_the_samples_about_each(width: int) -> None:
    np.testing.assert_array_equal(running_maximum(READINGS, width), ndimage.maximum_filter1d(READINGS, width))
    np.testing.assert_array_equal(running_minimum(READINGS, width), ndimage.minimum_filter1d(READINGS, width))


@pytest.mark.parametrize("width", [1, 5, 9])
def test_the_median_is_that_of_the_samples_about_each(width: int) -> None:
    np.testing.assert_array_equal(
        running_median(READINGS, width), ndimage.median_filter(READINGS, width, mode="nearest")
    )


@pytest.mark.parametrize("spans", [1, 2, 9])
@pytest.mark.parametrize("order", [0, 1, 2])
def test_splines_and_their_derivatives_are_scipy_s(spans: int, order: int) -> None:
    points, step = np.linspace(-1.0, 3.0, 83), 4.0 / spans
    weights = np.random.default_rng(2).normal(size=spans + 3)
    knots = -1.0 + step * np.arange(-3.0, spans + 4.0)
    first, values = basis(points, -1.0, 3.0, spans, order)
    found = np.sum(values * weights[first[:, None] + np.arange(4)], axis=1)
    # the third derivative jumps at knots, on which points may fall: the second is rounded by some ten times 1e-16 of it
    np.testing.assert_allclose(found, BSpline(knots, weights, 3).derivative(order)(points), atol=1e-11)
