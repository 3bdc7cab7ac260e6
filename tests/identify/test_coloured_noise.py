import numpy as np
import pytest
from scipy import signal

from identify.signal.coloured_noise import Colour, Component, Whitening, autocovariance, spectrum

RATE = 256.0
PARTS = (Component(3.0, 0.5), Component(0.8, 20.0), Component(4.0, 0.1, 50.0))


def covariance(n):
    """The covariance from its closed form: exponentials, and one that turns."""
    lag = np.abs(np.subtract.outer(np.arange(n), np.arange(n))) / RATE
    total = np.eye(n)
    for c in PARTS:
        total = total + c.variance * np.exp(-2 * np.pi * c.corner * lag) * np.cos(
            2 * np.pi * c.frequency * lag
        )
    return total


def test_the_filter_whitens_over_gaps_exactly():
    used = np.random.default_rng(1).random(150) > 0.25
    used[40:60] = False
    filtered = Whitening(PARTS, RATE, used)(np.eye(150))[used][:, used]
    whitened = filtered @ covariance(150)[used][:, used] @ filtered.T
    np.testing.assert_allclose(whitened, np.eye(int(used.sum())), atol=1e-12)  # rounding of 150 steps


def test_the_autocovariance_is_the_closed_form():
    found = np.eye(80)[0] + autocovariance(PARTS, np.arange(80.0), RATE)
    np.testing.assert_allclose(found, covariance(80)[0], rtol=1e-12)


def test_drawn_noise_has_the_spectrum_that_is_stated():
    used = np.ones(4096, dtype=bool)
    drawn = Whitening(PARTS[:2], RATE, used).draw(np.random.default_rng(2), 60)
    frequency, power = signal.periodogram(drawn, RATE, "hann", axis=0)
    stated = spectrum(PARTS[:2], frequency, RATE) * 2.0 / RATE
    for low, high in ((0.5, 2.0), (2.0, 10.0), (10.0, 60.0), (60.0, 120.0)):
        band = (frequency > low) & (frequency < high)
        # at least 24 bins of 60 draws: 4 % by chance
        assert np.mean(power[band] / stated[band][:, None]) == pytest.approx(1.0, abs=0.12)


def test_an_uncertain_strength_is_that_of_the_colour_and_not_of_its_lines():
    stronger = Colour(PARTS, 0.3).stronger(2.0)
    assert [c.variance for c in stronger] == [6.0, 1.6, 4.0]
