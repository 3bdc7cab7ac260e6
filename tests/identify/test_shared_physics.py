"""Whether releases share their physics: alike ones do, another spring is found out, and an amplitude is no other spring."""

import numpy as np
import pytest

from identify.comparison.shared_physics import shared_physics
from identify.free_decay import FreeDecay
from identify.preprocessing.prepared_decay import prepare
from mocks.generate import PHYSICS, draw

STIFFNESS, FIXED = 613.6, {"mu_0": 0.13, "mu_1": 0.29}


def release(
    seed, effect=None, strength=0.0, *, stiffness=STIFFNESS, amplitude=0.02, seconds=5.0, **parameters
):
    fixed = FIXED | {"parameters": {effect: parameters}} if parameters else FIXED
    sample = draw(effect, strength, seed, stiffness=stiffness, amplitude=amplitude, seconds=seconds, **fixed)
    return prepare(FreeDecay(sample.rate, sample.displacement, sample.acceleration)), sample.truth


def test_releases_of_one_bench_do_not_differ_at_whatever_amplitude():
    decays = [release(seed, amplitude=a)[0] for seed, a in ((1, 0.02), (2, 0.01), (3, -0.015))]
    found = shared_physics(decays)
    assert found.differences == ()
    assert found.other_benches == ()
    k = found.own[0].parameters[found.own[0].stiffness]
    assert abs(k.value - STIFFNESS) < 5 * k.std


def test_a_spring_three_per_cent_softer_is_found_out_and_said_in_words():
    found = shared_physics([release(1)[0], release(2)[0], release(3, stiffness=0.969 * STIFFNESS)[0]])
    (difference,) = found.differences
    assert difference.index == 2
    assert difference.percent == pytest.approx(-3.1, abs=0.01)
    assert difference.words("a").startswith("stiffness per unit mass 3.10 % lower than a (")
    assert found.other_benches == ()


@pytest.mark.parametrize("effect", ["cubic_stiffness", "quadratic_damping"])
def test_what_another_amplitude_does_on_a_nonlinear_bench_is_no_difference(effect):
    large, truth = release(1, effect, 0.03)
    small, _ = release(2, effect, 0.03, amplitude=0.01, **truth["parameters"])
    found = shared_physics([large, small])
    k = [own.parameters[own.stiffness].value for own in found.own]
    assert (
        effect != "cubic_stiffness" or abs(k[0] / k[1] - 1.0) > 0.01
    )  # the usual model does see another spring
    assert found.differences == ()


def test_a_spring_twice_as_stiff_is_another_bench():
    found = shared_physics([release(1)[0], release(2, stiffness=2.2 * STIFFNESS)[0]])
    assert found.other_benches == (1,)
    assert all(np.isfinite(difference.sigmas) for difference in found.differences)


def test_a_spring_eight_times_as_stiff_is_another_bench_however_badly_the_usual_model_follows():
    decays = [release(1, "cubic_stiffness", 0.1)[0]]
    decays.append(release(2, "cubic_stiffness", 0.1, stiffness=8.0 * STIFFNESS)[0])
    assert shared_physics(decays).other_benches == (1,)


@pytest.mark.slow
@pytest.mark.parametrize("effect", PHYSICS)
def test_no_effect_of_the_library_makes_two_releases_of_one_bench_differ(effect):
    large, truth = release(3, effect, 0.02)
    small, _ = release(53, effect, 0.02, amplitude=0.012, **truth["parameters"])
    assert shared_physics([large, small]).differences == ()
