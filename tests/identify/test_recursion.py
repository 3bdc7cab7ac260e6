"""The first-order recursion, against its sum."""

import numpy as np

from identify.recursion import recursion


def test_a_recursion_is_the_sum_of_what_came_before_ever_weaker():
    x = np.random.default_rng(3).normal(size=(40, 2))
    expected = np.array([sum(0.8 ** (i - j) * x[j] for j in range(i + 1)) for i in range(40)])
    assert np.allclose(recursion(x, 0.8), expected, rtol=1e-12)
    assert np.allclose(recursion(x[:, 0], 0.8), expected[:, 0], rtol=1e-12)
    assert np.array_equal(recursion(x, 0.0), x)
