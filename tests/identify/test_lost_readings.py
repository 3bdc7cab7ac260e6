import numpy as np
import pytest

from identify.free_decay import FreeDecay
from identify.preprocessing.lost_readings import find_lost_readings
from identify.restoring_force.restoring_force import identify_restoring_force
from mocks.generate import draw

RATE = 256.0


def decay(noise: float, seed: int = 0, samples: int = 2048) -> np.ndarray:
    time = np.arange(samples) / RATE
    random = np.random.default_rng(seed)
    return 0.02 * np.exp(-0.3 * time) * np.cos(25.0 * time) + noise * random.standard_normal(samples)


@pytest.mark.parametrize("seed", range(5))
def test_readings_that_repeat_while_the_motion_runs_on_are_found_and_no_others(seed):
    random = np.random.default_rng(seed)
    noise = 5e-6
    reading = decay(noise, seed)
    # The motion passes zero at these samples, where it is quickest: a repeated reading is far off.
    crossings = np.flatnonzero(np.diff(np.sign(reading)) != 0)[2:40:3]
    lengths = random.integers(1, 4, len(crossings))
    wanted = np.zeros(len(reading), dtype=bool)
    for at, length in zip(crossings, lengths, strict=True):
        reading[at : at + length] = reading[at - 1]
        wanted[at : at + length] = True
    assert np.array_equal(find_lost_readings(reading, noise), wanted)


def test_a_clean_decay_has_none():
    for seed in range(20):
        assert not find_lost_readings(decay(5e-6, seed), 5e-6).any()


def test_a_reading_that_flies_off_alone_is_one():
    reading = decay(5e-6)
    reading[700] += 0.01
    assert np.flatnonzero(find_lost_readings(reading, 5e-6)).tolist() == [700]


def test_equal_readings_on_either_side_of_a_peak_are_no_dropout():
    # Two samples placed evenly about a crest are equal; sixteen a cycle, so that the cubic misses by far more than noise.
    angle = 2 * np.pi * (np.arange(800) + 0.5) / 16
    reading = np.round(np.cos(angle), 9)
    assert not find_lost_readings(reading, 1e-6).any()


def test_a_quick_motion_for_its_rate_is_not_called_a_faulty_sensor():
    random = np.random.default_rng(4)
    time = np.arange(4096) / 610.0
    lines = random.uniform(20.0, 150.0, 60)  # as little as four samples a cycle
    phases = random.uniform(0.0, 2 * np.pi, 60)
    reading = np.round(np.sin(2 * np.pi * np.outer(time, lines) + phases).sum(axis=1), 2)
    assert (reading[1:] == reading[:-1]).any()
    assert not find_lost_readings(reading, 0.003).any()


def test_the_last_cycles_of_a_coarse_converter_are_no_dropout():
    """A motion of a few steps stands still for several readings about its peaks, by rounding."""
    time = np.arange(400) / 100.0
    for phase in np.arange(0.0, 2 * np.pi, 0.1):
        reading = 2.0 * np.round(60.0 * np.exp(-3.0 * time) * np.cos(18.2 * time + phase))
        assert not find_lost_readings(reading, 2.0 / np.sqrt(12.0)).any()


def test_the_jump_of_dry_friction_in_coarse_steps_is_no_dropout():
    """At a reversal the acceleration jumps by four steps, and a reading beside it repeats the one before by itself."""
    for seed in range(20):
        sample = draw(
            None, 0.0, 500 + seed, mu_0=0.38, amplitude=0.02, rate=1500.0, bits=10, noise_acceleration=0.03
        )
        free = int((sample.truth["released_at_s"] + 0.05) * sample.rate)
        assert not find_lost_readings(sample.acceleration, 0.04)[free:].any()


@pytest.mark.parametrize("seed", [0, 2])
def test_short_bursts_far_off_leave_the_damping_as_sure_as_without_them(seed):
    reading, random = decay(5e-6, seed), np.random.default_rng(seed)
    for at in (300, 800, 1400):
        burst = random.integers(3, 6)
        reading[at : at + burst] += 0.004 * random.choice([-1, 1], burst)
    viscous = identify_restoring_force(FreeDecay(RATE, reading)).damping[1]
    assert viscous.std < 1e-3
    assert viscous.value == pytest.approx(0.6, abs=5 * viscous.std)
