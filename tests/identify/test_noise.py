import numpy as np
import pytest
from decays_in_closed_form import coulomb, exponential

from identify.free_decay import FreeDecay
from identify.preprocessing.noise import (
    floor_above_motion,
    floor_at_rest,
    noise_of,
    with_steps,
)


def test_the_floor_at_rest_is_the_white_noise_with_its_stated_error() -> None:
    z = []
    for seed in range(200):
        rest = 3.0 + 5e-6 * np.random.default_rng(seed).standard_normal(190)
        found = floor_at_rest(rest)
        z.append((found.std - 5e-6) / found.uncertainty)
    assert abs(np.mean(z)) < 0.5  # z has unit variance; half of it is a bias nobody would notice
    assert 0.7 < np.std(z) < 1.3  # 200 draws leave 5 % on it; the rest is the approximation


def test_drift_and_hum_do_not_count_as_white_noise() -> None:
    time = np.arange(190) / 256
    noise = 0.01 * np.random.default_rng(3).standard_normal(190)
    rest = 0.3 + 0.1 * time + 0.06 * np.sin(2 * np.pi * 50 * time) + noise
    assert floor_at_rest(rest).std == pytest.approx(0.01, rel=0.2)  # 190 samples know it within 6 %


def test_without_rest_the_noise_is_read_above_the_motion() -> None:
    time = np.arange(1500) / 256
    u, _, a = coulomb(time, 3.944)
    rng = np.random.default_rng(5)
    decay = FreeDecay(
        256.0,
        displacement=u + 5e-6 * rng.standard_normal(1500),
        acceleration=a + 0.01 * rng.standard_normal(1500),
    )
    found = noise_of(decay)
    assert found["displacement"].std == pytest.approx(5e-6, rel=0.12)  # three times the stated 4 %
    # A reversal every half-cycle touches seven differences in 32; most are clipped off, not all.
    assert found["acceleration"].std == pytest.approx(0.01, rel=0.16)
    assert "velocity" not in found
    assert found["displacement"].source == "band above the motion"


def test_lost_samples_do_not_count() -> None:
    u, _, _ = exponential(np.arange(1000) / 256, 3.944)
    u = u + 5e-6 * np.random.default_rng(6).standard_normal(1000)
    valid = np.ones(1000, dtype=bool)
    valid[::40] = False
    u[~valid] = 5.0
    assert floor_above_motion(u, valid).std == pytest.approx(
        5e-6, rel=0.1
    )  # 800 differences know it within 6 %


def test_where_readings_are_lost_everywhere_the_noise_is_read_off_those_that_are_left() -> None:
    """A camera of 30 frames a second of which two in three were kept: no seven readings stand side by side."""
    u, _, _ = exponential(np.arange(1000) / 256, 3.944)
    u = u + 5e-6 * np.random.default_rng(6).standard_normal(1000)
    valid = np.arange(1000) % 3 > 0
    u[~valid] = 5.0
    found = floor_above_motion(u, valid)
    assert abs(found.std - 5e-6) < 4.0 * found.uncertainty
    assert found.uncertainty < 0.1 * found.std


def test_noise_that_no_readings_show_is_not_known() -> None:
    valid = np.arange(60) % 9 == 0
    found = noise_of(FreeDecay(30.0, displacement=np.cos(np.arange(60.0)), valid=valid))["displacement"]
    assert np.isinf(found.uncertainty)


def test_a_converter_that_shows_nothing_but_steps_has_the_noise_of_a_step() -> None:
    steps = np.round(np.linspace(0.0, 20.0, 400))
    assert floor_above_motion(steps).std >= 1 / np.sqrt(12.0) - 1e-12


@pytest.mark.parametrize("noise", [0.0, 0.05])
def test_a_rest_that_stands_on_one_step_hides_an_error_that_the_motion_shows(noise: float) -> None:
    # Bennett: along a motion over many steps their error is uniform, of variance step^2 / 12.
    step = 2.5e-5
    u, _, _ = exponential(np.arange(1500) / 256, 3.944)
    u = np.concatenate([np.full(200, u[0]), u]) + 0.3 * step
    u = step * np.round((u + noise * step * np.random.default_rng(8).standard_normal(1700)) / step)
    found = noise_of(FreeDecay(256.0, displacement=u, release=200, rest=(0, 200)))["displacement"]
    assert abs(found.std - step * np.hypot(noise, 12**-0.5)) < 2.0 * found.uncertainty
    assert found.source == "rest before the release, and the converter's steps"


def test_noise_that_carries_the_rest_over_the_steps_has_shown_their_error_already() -> None:
    step = 1.0
    rest = np.round(0.8 * np.random.default_rng(9).standard_normal(4000))
    found = with_steps(floor_at_rest(rest), step)
    assert found.std == pytest.approx(np.hypot(0.8, 12**-0.5), rel=0.05)  # 4000 samples know it within 1.1 %


def test_a_record_without_any_noise_still_has_a_noise_to_divide_by() -> None:
    u, _, _ = exponential(np.arange(1000) / 256, 3.944)
    u = np.concatenate([np.full(100, u[0]), u])
    assert noise_of(FreeDecay(256.0, displacement=u, release=100, rest=(0, 100)))["displacement"].std > 0.0
