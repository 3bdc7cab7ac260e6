"""The motion of the release: what a smooth curve through it would ring over, its integral follows."""

import numpy as np
import pytest
from releases import drawn
from scipy.integrate import solve_ivp

from identify.diagnosis.diagnose import diagnose
from identify.effects.library import find_effect
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


def test_what_is_driven_along_a_motion_of_few_readings_follows_the_motion_between_them():
    """A second mass at 17 Hz on a motion of 4 Hz, 25 readings a cycle; along straight lines it is a hundredth off."""
    w2, zeta, w = 105.0, 0.016, 2.0 * np.pi * 4.0
    time = np.arange(12) / 100.0

    def slope(t, z):
        u, v = np.cos(w * t), -w * np.sin(w * t)
        return [z[1], w2**2 * (u - z[0]) + 2.0 * zeta * w2 * (v - z[1])]

    exact = solve_ivp(slope, (0.0, time[-1]), [1.0, 0.0], t_eval=time, rtol=1e-10, atol=1e-12).y[0]
    second = find_effect("second_mass")
    p = (0.04, w2, zeta, 0.0, 0.0, 0.0)
    found = second.states_along(p, time, np.cos(w * time), -w * np.sin(w * time), (1.0, 0.0), steps=64)
    assert np.max(np.abs(found[:, 0] - exact)) < 2e-3
