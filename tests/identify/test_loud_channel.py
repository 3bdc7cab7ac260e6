"""One channel whose noise is a tenth of its motion: what is made of it has less noise than a reading, and is judged."""

from dataclasses import replace

import numpy as np
import pytest
from decays_in_closed_form import exponential
from specimens import among

from identify.arrays import Array
from identify.diagnosis.diagnose import diagnose
from identify.errors import NotIdentifiable
from identify.free_decay import FreeDecay
from identify.judging.nonparametric_force import nonparametric_force
from identify.preprocessing.prepared_decay import prepare

RATE, FREQUENCY = 50.0, 1.1
SIZES = {"displacement": 0.02, "acceleration": 0.02 * (2.0 * np.pi * FREQUENCY) ** 2}


def decay(channel: str, noise: float, seed: int = 0) -> FreeDecay:
    """Return 15 s of a viscous decay in one channel with white noise, as a share of its first amplitude."""
    time = np.arange(round(15.0 * RATE)) / RATE
    u, _, a = exponential(time, FREQUENCY, decay=0.12)
    values: Array = u if channel == "displacement" else a
    loud = values + noise * SIZES[channel] * np.random.default_rng(seed).standard_normal(len(time))
    return FreeDecay(RATE, **{channel: loud})


@pytest.mark.parametrize("channel", list(SIZES))
def test_a_decay_in_a_tenth_of_noise_is_followed_far_down(channel: str) -> None:
    prepared = prepare(decay(channel, 0.1))
    assert prepared.frequency / (2.0 * np.pi) == pytest.approx(FREQUENCY, rel=0.05)
    cycles = len(prepared.window) / prepared.window.rate * FREQUENCY
    # 8 standard deviations of a reading are 0.8 of the amplitude: two cycles; of what is smoothed about 0.3: ten
    assert cycles > 8.0


@pytest.mark.parametrize("channel", ["displacement", pytest.param("acceleration", marks=pytest.mark.slow)])
def test_in_a_decay_with_a_tenth_of_noise_nothing_is_missing(channel: str) -> None:
    few = ("cubic_stiffness", "settling_stiffness", "quadratic_damping", "hysteresis", "harmonic_forcing")
    found = diagnose(decay(channel, 0.1), library=among(*few))
    assert found.verdict == "nothing_missing"
    k = found.baseline.fit.parameters["linear_stiffness.k"].value
    assert k == pytest.approx((2.0 * np.pi * FREQUENCY) ** 2, rel=0.01)


@pytest.mark.parametrize("channel", list(SIZES))
def test_a_quiet_channel_is_cut_by_the_noise_of_a_reading_as_before(channel: str) -> None:
    assert prepare(decay(channel, 0.01)).motion.noise_displacement is None


def test_no_sign_is_doubted_where_there_is_one_channel_only() -> None:
    with pytest.raises(NotIdentifiable) as caught:
        prepare(decay("displacement", 0.5, seed=2))
    assert "sign reversed" not in str(caught.value)
    assert "noise" in str(caught.value)


def test_a_free_form_of_readings_whose_velocity_is_never_sure_explains_nothing() -> None:
    prepared = prepare(decay("displacement", 0.01))
    drowned = replace(prepared, motion=replace(prepared.motion, noise_velocity=1e3))
    found = nonparametric_force(drowned, np.zeros(len(prepared.motion.displacement)))
    assert found.shapes == ()
    assert found.coordinates == ()
