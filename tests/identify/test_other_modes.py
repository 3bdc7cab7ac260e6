"""A second mode is told with its frequency and size; hum, shaking, harmonics and noise are none."""

import numpy as np
import pytest
from releases import drawn

from identify.diagnosis.other_modes import modes_sentence, other_modes
from identify.fitting.baseline import fit_baseline
from identify.free_decay import FreeDecay
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import prepare

RATE, FIRST, AMPLITUDE = 256.0, 3.94, 0.02


def two_modes(frequency: float, share: float, damping: float):
    """Return the fit of the usual model to two linear modes in closed form, and the noise of a converter."""
    time = np.arange(2048) / RATE
    reading = np.random.default_rng(0).normal(0.0, 5e-6, len(time))
    for f, zeta, size in ((FIRST, 0.01, AMPLITUDE), (frequency, damping, share * AMPLITUDE)):
        reading += size * np.exp(-2.0 * np.pi * f * zeta * time) * np.cos(2.0 * np.pi * f * time)
    return fit_baseline((prepare(FreeDecay(RATE, reading)),), base_model()).fit


@pytest.mark.parametrize(("frequency", "damping"), [(2.2, 0.01), (5.7, 0.01), (9.7, 0.005)])
def test_a_second_mode_is_told_with_its_frequency_and_size(frequency, damping):
    (found,) = other_modes(two_modes(frequency, 0.1, damping))
    assert found.frequency == pytest.approx(frequency, abs=0.06)  # a quarter of a bin of four seconds
    assert 3.0 < found.percent < 12.0  # 10 % at the release, the mean of four seconds in which both fall
    assert f"{found.frequency:.3g} Hz" in modes_sentence((found,))


def test_a_line_that_does_not_die_away_is_no_mode():
    assert other_modes(two_modes(9.7, 0.1, 0.0)) == ()


@pytest.mark.parametrize(
    "effect", [None, "cubic_stiffness", "mains_hum", "harmonic_forcing", "end_stop", "hysteresis"]
)
def test_noise_harmonics_hum_and_shaking_are_no_modes(effect):
    fit = fit_baseline((drawn(effect, 0.02, 60)[0],), base_model()).fit
    assert other_modes(fit) == ()
    assert modes_sentence(()) == ""
