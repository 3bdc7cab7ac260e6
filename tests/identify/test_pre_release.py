"""The motion of the release: what a smooth curve through it would ring over, its integral follows."""

import numpy as np
import pytest
from releases import drawn

from identify.diagnosis.diagnose import diagnose
from identify.free_decay import FreeDecay
from identify.preprocessing.aligned_decay import locate_and_align
from identify.preprocessing.pre_release import pre_release_motion
from mocks.generate import draw
from mocks.testbed import Bench, Release, simulate


@pytest.mark.parametrize("hand", [0.002, 0.008])
def test_the_motion_at_a_quick_release_is_that_of_the_bench(hand):
    sample = draw(None, 0.0, 62700, release_time=hand)
    truth = sample.truth
    aligned = locate_and_align(FreeDecay(sample.rate, sample.displacement, sample.acceleration))
    seen = pre_release_motion(aligned, aligned.release, truth["offset_m"])
    since = seen.time + aligned.release.time_s - truth["released_at_s"]
    bench = Bench(truth["stiffness_per_mass"], truth["mu_0"], truth["mu_1"])
    true = simulate(bench, Release(truth["from_m"], 0.0, hand), since)
    # where the acceleration sets in is known to half a sample: 10 m/s^2 for 2 ms, in which the mass moves 0.02 mm
    assert np.max(np.abs(seen.velocity - true.velocity)) < 0.02
    assert np.max(np.abs(seen.displacement - true.displacement)) < 4e-5


@pytest.mark.slow
def test_a_second_mass_far_above_the_motion_is_named():
    prepared, truth = drawn("second_mass", 0.03, 62700)
    assert truth["parameters"]["w2"] > 4.5 * np.sqrt(truth["stiffness_per_mass"])
    found = diagnose(prepared)
    assert found.named == ("second_mass",)
    w2 = found.final.values["second_mass.w2"]
    assert w2.value == pytest.approx(truth["parameters"]["w2"], rel=2e-3)
