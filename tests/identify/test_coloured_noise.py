import numpy as np

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


def test_the_spectrum_is_that_of_the_autocovariance():
    lags = np.arange(1 - 4096, 4096)  # the slowest process has died away to 1e-11
    frequency = np.array([0.0, 0.7, 3.0, 49.9, 50.0, 128.0])
    waves = np.cos(2.0 * np.pi * np.outer(frequency, lags) / RATE)
    summed = 1.0 + waves @ autocovariance(PARTS, lags.astype(float), RATE)
    np.testing.assert_allclose(spectrum(PARTS, frequency, RATE), summed, rtol=1e-3)


def test_an_uncertain_strength_is_that_of_the_colour_and_not_of_its_lines():
    frequency, error = np.array([0.2, 9.0, 50.0]), 1e-6
    stronger = tuple(c if c.frequency else Component(c.variance * (1.0 + error), c.corner) for c in PARTS)
    change = np.log(spectrum(stronger, frequency, RATE) / spectrum(PARTS, frequency, RATE)) / error
    found = Colour(PARTS, 0.3).log_error(frequency, RATE)
    np.testing.assert_allclose(found, 0.3 * change, rtol=1e-5)
