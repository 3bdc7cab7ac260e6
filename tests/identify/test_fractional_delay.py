import numpy as np
import pytest

from identify.signal.fractional_delay import lagrange_slope_taps, lagrange_taps, read_at_shift


@pytest.mark.parametrize("fraction", [-0.5, -0.2, 0.0, 0.31, 0.5])
def test_the_taps_read_polynomials_of_degree_six_exactly(fraction: float) -> None:
    nodes = np.arange(-3, 4)
    for degree in range(7):
        assert lagrange_taps(fraction) @ nodes**degree == pytest.approx(fraction**degree, abs=1e-12)


def test_the_slope_of_the_taps_is_their_derivative() -> None:
    step = 1e-6
    numeric = (lagrange_taps(0.2 + step) - lagrange_taps(0.2 - step)) / (2 * step)
    assert lagrange_slope_taps(0.2) == pytest.approx(
        numeric, abs=1e-8
    )  # truncation of the difference is 1e-12


@pytest.mark.parametrize("shift", [-7.3, -0.77, -0.5, 0.25, 0.768, 12.5])
def test_a_sine_is_read_between_its_samples(shift: float) -> None:
    x = 2 * np.pi * 3.944 / 256 * np.arange(600)
    moved, known = read_at_shift(np.sin(x), shift)
    truth = np.sin(x + 2 * np.pi * 3.944 / 256 * shift)
    inside = known.copy()
    inside[:20] = inside[-20:] = False
    assert np.max(np.abs(moved - truth)[inside]) < 1e-9  # (w dt)^7 over 2^7: seven points of a 65-point cycle
    assert np.max(np.abs(moved - truth)[known]) < 1e-5  # a cubic at the very ends


def test_what_lies_beyond_the_record_is_marked_and_held() -> None:
    moved, known = read_at_shift(np.linspace(0.0, 1.0, 50), 3.4)
    assert not known[-3:].any()
    assert known[:-4].all()
    assert np.all(moved[-3:] == 1.0)


def test_a_release_from_rest_does_not_ring() -> None:
    time = np.arange(400) / 256 - 0.7513
    released = np.where(time < 0, 0.02, 0.02 * np.cos(24.8 * time))
    moved, known = read_at_shift(released, 0.5)
    shifted = time + 0.5 / 256
    truth = np.where(shifted < 0, 0.02, 0.02 * np.cos(24.8 * shifted))
    error = np.abs(moved - truth) * known
    at = int(np.searchsorted(shifted, 0.0))
    assert error[: at - 4].max() < 1e-15  # finite support: nothing before it
    # The kink leaves a fifteenth of jump times dt^2 at the most, about the noise of a good sensor.
    assert error.max() < 24.8**2 * 0.02 / 256**2 / 15


def test_a_lost_sample_is_lost_after_the_move_and_its_neighbours_with_it() -> None:
    valid = np.ones(100, dtype=bool)
    valid[40] = False
    values = np.sin(0.1 * np.arange(100))
    values[40] = 1e9
    moved, known = read_at_shift(values, 0.5, valid)
    assert not known[38:42].any()
    assert known[:36].all()
    assert np.all(np.abs(moved[known]) < 1.1)
