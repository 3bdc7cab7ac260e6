"""A smooth law outside the library: none is seen in noise or in a random walk, and one where the library has none."""

import pytest
from releases import ready

from identify.fitting.baseline import fit_baseline
from identify.fitting.random_walk import walk_beside
from identify.judging.beside_walk import smooth_law_beside
from identify.model.model import base_model
from mocks.generate import draw


def usual_model(hidden, strength, seed):
    sample = draw(hidden, strength, seed)
    prepared = ready(sample.rate, sample.displacement, sample.acceleration)
    return fit_baseline((prepared,), base_model()).fit


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_noise_shows_no_law(seed):
    found = usual_model(None, 0.0, seed)
    assert smooth_law_beside(walk_beside(found)) < 0.0


@pytest.mark.parametrize(
    "hidden", ["one_sided_friction", "magnet", "notched_spring", "adhesion", "cubic_damping"]
)
def test_a_law_is_seen_whether_it_has_a_name_or_not(hidden):
    found = usual_model(hidden, 0.003, 1)
    walk = walk_beside(found)
    explains = smooth_law_beside(walk)
    assert explains > 10.0
    assert explains + walk.evidence < 0.5 * found.chi_square


def test_a_random_walk_is_no_law():
    found = usual_model("wandering_stiffness", 0.0003, 1)
    walk = walk_beside(found)
    assert walk.evidence > 10.0
    assert smooth_law_beside(walk) < 4.0
