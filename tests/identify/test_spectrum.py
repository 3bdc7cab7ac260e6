import numpy as np
import pytest

from identify.signal.spectrum import high_band_floor, strongest_lines

RATE, N = 256.0, 2048
CLOCK = np.arange(N) / RATE


def line(frequency, amplitude, phase, time=0.0):
    return amplitude * np.sin(2 * np.pi * frequency * (CLOCK + time) + phase)


def test_a_line_between_two_bins_is_found_with_its_phase_at_time_zero():
    ((f, amplitude, phase),) = strongest_lines(line(50.03, 0.3, 1.2, time=0.25), RATE, 0.25, 1)
    assert f == pytest.approx(
        50.03, abs=0.005
    )  # a twentieth of a bin of 1/8 Hz, from the parabola through the peak
    assert amplitude == pytest.approx(0.3, rel=0.02)
    assert phase == pytest.approx(1.2, abs=0.15)  # 0.005 Hz over the 4 s to the middle of the record


def test_lines_come_strongest_first():
    found = strongest_lines(line(20.0, 0.1, 0.3) + line(60.0, 0.5, 2.0) + line(97.0, 0.2, 5.0), RATE, 0.0, 3)
    assert [round(f) for f, _, _ in found] == [60, 97, 20]


def test_a_residual_of_zeros_has_no_lines():
    assert strongest_lines(np.zeros(N), RATE, 0.0, 3) == ()


def test_the_floor_is_the_white_noise_within_its_stated_error_whatever_lies_below_the_band():
    z = []
    for seed in range(100):
        noise = 0.01 * np.random.default_rng(seed).standard_normal(N)
        std, error = high_band_floor(noise + line(4.0, 1.0, 0.5) + line(50.0, 0.05, 1.0), RATE, 32.0)
        z.append((std - 0.01) / error)
    assert abs(np.mean(z)) < 0.5  # half a standard error is a bias nobody would notice
    assert 0.6 < np.std(z) < 1.3  # stated for the worst case, so 1 or a little less; 100 draws leave 7 %


def test_a_band_too_narrow_gives_no_floor():
    assert not np.isfinite(high_band_floor(np.ones(64), RATE, 120.0)[1])


@pytest.mark.parametrize("seed", range(80, 90))
def test_lines_of_a_residual_that_wanders_lie_in_the_band_that_is_looked_at(seed: int) -> None:
    """Its power falls from below the band on: the first bin in it is the largest, and no peak."""
    walk = np.cumsum(np.random.default_rng(seed).standard_normal(800))
    lowest = 1.5 * 50.0 / 800
    for frequency, amplitude, _ in strongest_lines(walk, 50.0, 0.0, 3):
        assert 0.9 * lowest < frequency < 25.0
        assert amplitude < np.ptp(walk)
