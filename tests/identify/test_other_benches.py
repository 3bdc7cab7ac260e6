"""Releases of another bench: a spring half as stiff again is one, another amplitude is none."""

import pytest

from identify.comparison.other_benches import other_benches
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


def test_releases_of_one_bench_are_of_one_at_whatever_amplitude():
    decays = [release(seed, amplitude=a)[0] for seed, a in ((1, 0.02), (2, 0.01), (3, -0.015))]
    assert other_benches([*decays, release(4, stiffness=0.969 * STIFFNESS)[0]]) == ()


@pytest.mark.parametrize("amplitude", [0.02, 0.01, 0.005])
def test_a_spring_half_as_stiff_again_is_another_bench_at_whatever_amplitude(amplitude):
    other = release(2, stiffness=1.5 * STIFFNESS, amplitude=amplitude)[0]
    for seconds in (5.0, 1.5):  # within which the amplitudes meet, or not
        assert other_benches([release(1, seconds=seconds)[0], other]) == (1,)


def test_a_spring_that_softens_within_a_release_is_no_other_bench_at_an_amplitude_that_it_never_comes_to():
    large = release(1, "cubic_stiffness", 0.4, seconds=1.5)[0]
    small = release(2, stiffness=1.2 * STIFFNESS, amplitude=0.007)[0]
    assert small.frequency**2 > 1.5 * large.frequency**2
    assert other_benches([large, small]) == ()
    assert other_benches([small, large]) == ()


def test_a_spring_eight_times_as_stiff_is_another_bench_however_badly_the_usual_model_follows():
    decays = [release(1, "cubic_stiffness", 0.1)[0]]
    decays.append(release(2, "cubic_stiffness", 0.1, stiffness=8.0 * STIFFNESS)[0])
    assert other_benches(decays) == (1,)


@pytest.mark.slow
@pytest.mark.parametrize("effect", PHYSICS)
def test_no_effect_of_the_library_makes_another_bench_of_a_second_release(effect):
    large, truth = release(3, effect, 0.02)
    small, _ = release(53, effect, 0.02, amplitude=0.012, **truth["parameters"])
    assert other_benches([large, small]) == ()
