import numpy as np
import pytest
from decays_in_closed_form import coulomb, exponential

from identify.free_decay import FreeDecay
from identify.preprocessing.noise import estimate_noise, floor_above_motion, floor_at_rest, noise_of


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
    filled = estimate_noise(decay)
    assert filled.noise_displacement == pytest.approx(5e-6, rel=0.12)  # three times the stated 4 %
    # A reversal every half-cycle touches seven differences in 32; most are clipped off, not all.
    assert filled.noise_acceleration == pytest.approx(0.01, rel=0.16)
    assert filled.noise_velocity is None
    assert noise_of(decay)["displacement"].source == "band above the motion"


def test_lost_samples_do_not_count() -> None:
    u, _, _ = exponential(np.arange(1000) / 256, 3.944)
    u = u + 5e-6 * np.random.default_rng(6).standard_normal(1000)
    valid = np.ones(1000, dtype=bool)
    valid[::40] = False
    u[~valid] = 5.0
    assert floor_above_motion(u, valid).std == pytest.approx(
        5e-6, rel=0.1
    )  # 800 differences know it within 6 %


def test_a_converter_that_shows_nothing_but_steps_has_the_noise_of_a_step() -> None:
    steps = np.round(np.linspace(0.0, 20.0, 400))
    assert floor_above_motion(steps).std >= 1 / np.sqrt(12.0) - 1e-12
