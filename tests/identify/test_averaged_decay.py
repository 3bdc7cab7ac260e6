"""A record far faster than its motion is averaged without a loss that a fit would see."""

import numpy as np
import pytest

from identify.fitting.baseline import fit_baseline
from identify.free_decay import FreeDecay
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import prepare
from identify.preprocessing.sampling import average_blocks, blocks_held
from mocks.generate import draw


@pytest.mark.parametrize("block", [2, 3, 7])
def test_a_blocks_mean_is_the_motion_in_its_middle(block: int) -> None:
    rate, frequency = 1000.0, 7.3
    swing = 0.02 * np.exp(2j * np.pi * frequency * np.arange(4000) / rate)
    recorded = FreeDecay(rate, 0.3 + swing.real, noise_displacement=1e-6, rest=(0, 0))
    averaged, begins = average_blocks(recorded, block, frequency)
    time = begins + np.arange(len(averaged)) / averaged.rate
    assert averaged.displacement == pytest.approx(
        0.3 + 0.02 * np.cos(2.0 * np.pi * frequency * time), abs=1e-6
    )


@pytest.mark.slow
def test_dry_friction_is_as_large_at_2000_hz_as_it_is() -> None:
    scores = []
    for seed in range(40, 45):
        sample = draw(None, 0.0, seed, amplitude=0.025, rate=2000.0)
        prepared = prepare(FreeDecay(sample.rate, sample.displacement, sample.acceleration))
        mu_0 = fit_baseline((prepared,), base_model()).fit.parameters["coulomb_friction.mu_0"]
        scores.append((mu_0.value - sample.truth["mu_0"]) / mu_0.std)
    # Each has a unit variance; uncorrected means move all of them by -2 to -8.
    assert abs(np.mean(scores)) < 1.8


def test_a_block_beside_a_long_loss_is_lost_and_one_with_a_short_loss_is_not() -> None:
    known = np.ones(40, dtype=bool)
    known[6] = False  # one reading of the second block of five
    known[17:24] = False  # two of the fourth, and the fifth
    assert blocks_held(known, 5).tolist() == [True, True, True, False, False, True, True, True]
