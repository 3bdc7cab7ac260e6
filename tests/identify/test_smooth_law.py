"""A smooth law outside the library: none is seen in noise or in a random walk, and one where the library has none."""

import numpy as np
import pytest
from releases import ready
from scipy.integrate import solve_ivp

from identify.fitting.baseline import fit_baseline
from identify.fitting.random_walk import walk_beside
from identify.free_decay import FreeDecay
from identify.judging.beside_walk import smooth_law_evidence
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import prepare
from mocks.generate import draw


def usual_model(hidden, strength, seed):
    sample = draw(hidden, strength, seed)
    prepared = ready(sample.rate, sample.displacement, sample.acceleration)
    return fit_baseline((prepared,), base_model()).fit


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_noise_shows_no_law(seed):
    found = usual_model(None, 0.0, seed)
    assert smooth_law_evidence(walk_beside(found)) < 0.0


@pytest.mark.parametrize(
    "hidden", ["one_sided_friction", "magnet", "notched_spring", "adhesion", "cubic_damping"]
)
def test_a_law_is_seen_whether_it_has_a_name_or_not(hidden):
    found = usual_model(hidden, 0.003, 1)
    walk = walk_beside(found)
    explains = smooth_law_evidence(walk)
    assert explains > 10.0
    assert explains + walk.evidence < 0.5 * found.chi_square


def test_a_random_walk_is_no_law():
    found = usual_model("wandering_stiffness", 0.0003, 1)
    walk = walk_beside(found)
    assert walk.evidence > 10.0
    assert smooth_law_evidence(walk) < 4.0


def test_walk_and_law_explain_no_more_than_there_is_where_the_motion_is_simulated_with_the_walk():
    walk = walk_beside(usual_model("cubic_stiffness+wandering_stiffness", (0.03, 0.003), 41000)).simulated
    assert walk.evidence > 1e6
    assert smooth_law_evidence(walk) + walk.evidence < 0.5 * walk.without


def test_a_law_that_a_walk_could_follow_is_no_less_a_law():
    """A spring that gives way beyond a deflection, one channel: a walk of the stiffness follows most of it, too."""

    def rates(_, y):
        return [y[1], -300.0 * y[0] - 0.4 * y[1] + 10.0 * np.sign(y[0]) * max(abs(y[0]) - 0.4, 0.0)]

    decays, time = [], np.arange(1600) / 200.0
    for seed, angle in enumerate((0.56, -0.28)):
        u = solve_ivp(rates, (0.0, 8.0), [angle, 0.0], t_eval=time, rtol=1e-9, atol=1e-11).y[0]
        noise = 1.3e-3 * np.random.default_rng(seed).standard_normal(len(u))
        decays.append(prepare(FreeDecay(200.0, displacement=u + noise, unit="rad")))
    walk = walk_beside(fit_baseline(tuple(decays), base_model()).fit)
    assert walk.evidence > 100.0
    assert smooth_law_evidence(walk) > 2.0
