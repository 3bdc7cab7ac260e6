from functools import cache

import numpy as np
import pytest
from releases import drawn

from identify.fitting.fit import fit, fit_at
from identify.fitting.initial_values import initial_values
from identify.fitting.problem import Problem
from identify.model.model import base_model


@cache
def fitted():
    prepared, truth = drawn(None, 0.0, 7100)
    model = base_model()
    found = fit(model, (prepared.window,), initial_values((prepared,), model, {}), prepared.frequency)
    return prepared, truth, found


def test_the_doubles_parameters_are_found_within_their_errors():
    _, truth, found = fitted()
    for name, true in (
        ("linear_stiffness.k", truth["stiffness_per_mass"]),
        ("coulomb_friction.mu_0", truth["mu_0"]),
        ("viscous_damping.mu_1", truth["mu_1"]),
        ("lag", truth["displacement_late_s"]),
    ):
        estimate = found.values[name]
        assert abs(estimate.value - true) < 4.0 * estimate.std, name  # 1 in 4000 by chance, each
    assert found.converged
    assert not found.unidentifiable
    assert 0.85 < found.reduced < 1.15  # the noise of a single record is known to some 6 %


def test_a_start_that_slips_cycles_comes_to_the_same_minimum():
    prepared, _, found = fitted()
    start = dict(zip(found.names, found.theta.tolist(), strict=True))
    start["linear_stiffness.k"] *= 1.05  # 2.5 % of the frequency: most of a cycle over the 31 of 8 s
    again = fit(found.model, (prepared.window,), start, prepared.frequency)
    for name in ("linear_stiffness.k", "coulomb_friction.mu_0", "viscous_damping.mu_1"):
        # both stop where a step gains less than 0.02 of chi-square: 0.14 standard errors
        assert abs(again.values[name].value - found.values[name].value) < 0.3 * found.values[name].std


def test_residuals_are_readings_less_predictions_and_make_up_chi_square():
    prepared, _, found = fitted()
    total = 0.0
    for channel in prepared.window.channels:
        used = prepared.window.used[channel]
        total += float(np.sum((found.residual(channel)[used] / prepared.window.sigma[channel]) ** 2))
    assert total == pytest.approx(found.chi_square, rel=1e-6)


def test_errors_of_two_losses_are_correlated():
    _, _, found = fitted()
    first, second = "coulomb_friction.mu_0", "viscous_damping.mu_1"
    np.testing.assert_allclose(found.covariance, found.covariance.T, rtol=1e-9)
    i, j = found.names.index(first), found.names.index(second)
    correlation = found.covariance[i, j] / np.sqrt(found.covariance[i, i] * found.covariance[j, j])
    assert -1.0 < correlation < -0.5  # both take energy: more of one asks for less of the other


def test_a_fit_as_it_stands_does_not_move():
    prepared, _, found = fitted()
    theta = found.theta.copy()
    theta[found.names.index("coulomb_friction.mu_0")] *= 1.02
    stood = fit_at(Problem(found.model, (prepared.window,), prepared.frequency), theta)
    assert np.array_equal(stood.theta, theta)
    assert stood.chi_square > found.chi_square
    assert not stood.converged
