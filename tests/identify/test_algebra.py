"""Banded systems, against dense algebra and against scipy."""

import numpy as np
import pytest
from scipy import linalg

from identify.algebra import (
    banded_cholesky,
    recursion,
    solve_banded,
    whiten,
)


def test_a_recursion_is_the_sum_of_what_came_before_ever_weaker():
    x = np.random.default_rng(3).normal(size=(40, 2))
    expected = np.array([sum(0.8 ** (i - j) * x[j] for j in range(i + 1)) for i in range(40)])
    assert np.allclose(recursion(x, 0.8), expected, rtol=1e-12)
    assert np.allclose(recursion(x[:, 0], 0.8), expected[:, 0], rtol=1e-12)
    assert np.array_equal(recursion(x, 0.0), x)


@pytest.mark.parametrize(("width", "n"), [(1, 5), (4, 3), (4, 60)])
def test_banded_systems_are_solved_as_dense_ones(width, n):
    random = np.random.default_rng(width + n)
    lower = np.tril(np.triu(random.normal(size=(n, n)), 1 - width)) + 4.0 * np.eye(n)
    dense = lower @ lower.T
    band = np.array([np.pad(np.diag(dense, -k), (0, min(k, n))) for k in range(width)])
    right = random.normal(size=(n, 3))
    assert np.allclose(solve_banded(band, right), np.linalg.solve(dense, right), rtol=1e-12)
    assert np.allclose(whiten(banded_cholesky(band), right), np.linalg.solve(lower, right), rtol=1e-12)
    if width <= n:
        assert np.allclose(banded_cholesky(band), linalg.cholesky_banded(band, lower=True), rtol=1e-12)


def test_a_matrix_that_is_not_positive_definite_has_no_factor():
    with pytest.raises(np.linalg.LinAlgError):
        banded_cholesky(np.array([[1.0, 1.0], [2.0, 0.0]]))
