"""Standard errors off the floor hold the truth where the misfit drifts beside the motion, and where releases differ."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from identify.fitting.baseline import fit_baseline
from identify.fitting.misfit_errors import CycleSums, misfit_density, scatter_of_scores, with_misfit_errors
from identify.fitting.segments import segments_of
from identify.free_decay import FreeDecay
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import prepare

RATE, SECONDS, OMEGA, DECAY, AMPLITUDE, NOISE = 64.0, 20.0, 12.0, 0.1, 0.02, 2e-6
TRUTH = {"linear_stiffness.k": OMEGA**2 + DECAY**2, "viscous_damping.mu_1": 2.0 * DECAY}


def wandering(seed: int, *, cycles: float, size: float, omega: float = OMEGA) -> FreeDecay:
    """Return a viscous decay whose phase and logarithm of amplitude wander by `size`, correlated over some cycles."""
    random = np.random.default_rng(seed)
    time = np.arange(int(RATE * SECONDS)) / RATE
    keeps = np.exp(-omega / (2.0 * np.pi * cycles * RATE))
    wander = np.zeros((2, len(time)))
    wander[:, 0] = random.standard_normal(2)
    for i in range(1, len(time)):
        wander[:, i] = keeps * wander[:, i - 1] + np.sqrt(1.0 - keeps**2) * random.standard_normal(2)
    motion = np.exp(-DECAY * time + size * wander[0]) * np.cos(omega * time + size * wander[1])
    return FreeDecay(RATE, displacement=AMPLITUDE * motion + NOISE * random.standard_normal(len(time)))


@cache
def off(count: int = 16) -> tuple[np.ndarray, np.ndarray]:
    """Return how many standard errors k and mu_1 are off: by the errors stated, and by those of white noise as dense."""
    stated, white = [], []
    for seed in range(count):
        found = fit_baseline((prepare(wandering(seed, cycles=4.0, size=0.01)),), base_model()).fit
        errors, dense = with_misfit_errors(found), np.sqrt(misfit_density(found))
        for name, true in TRUTH.items():
            stated.append((found.values[name].value - true) / errors.values[name].std)
            white.append((found.values[name].value - true) / (found.values[name].std * dense))
    return np.array(stated), np.array(white)


def test_errors_hold_the_truth_where_phase_and_amplitude_wander():
    """Of 32 normal errors a median size above 1.0, for 0.67, or fewer than 26 within two has a chance of 1 %."""
    stated, white = off()
    assert np.median(np.abs(stated)) < 1.0
    assert (np.abs(stated) < 2.0).sum() >= 26
    assert np.median(np.abs(white)) > 1.0  # noise as dense as the misfit is not enough


def test_errors_are_no_smaller_than_those_of_the_noise():
    found = fit_baseline((prepare(wandering(3, cycles=4.0, size=0.0)),), base_model()).fit
    errors = with_misfit_errors(found)
    for name in TRUTH:
        assert found.values[name].std <= errors.values[name].std < 2.0 * found.values[name].std


def sums_of_noise(seed: int, cycles: int) -> CycleSums:
    """Return a channel with white noise of variance 4 and two unknowns, one that follows amplitude and one phase."""
    random = np.random.default_rng(seed)
    position = np.arange(float(cycles))
    columns = np.zeros((2, 2, cycles))
    columns[0, 0] = columns[1, 1] = position / cycles
    return CycleSums(
        0, np.arange(2), 2.0 * random.standard_normal((2, cycles)), columns, np.ones(cycles), position, 0.0, 0
    )


def test_the_scatter_of_white_noise_is_that_of_least_squares():
    sums = sums_of_noise(1, 400)
    scatter = scatter_of_scores([sums], 2, 1)
    assert scatter is not None
    expected = 4.0 * np.einsum("pak,qak->pq", sums.columns, sums.columns)
    assert np.diag(scatter[0]) == pytest.approx(np.diag(expected), rel=0.3)


def test_too_few_cycles_have_no_scatter():
    assert scatter_of_scores([sums_of_noise(1, 2)], 2, 1) is None


def together(other: float) -> dict[str, float]:
    """Return the errors of the parameters of two releases that are fitted together, the second at another frequency."""
    decays = [
        wandering(seed, cycles=4.0, size=0.003, omega=omega) for seed, omega in ((1, OMEGA), (2, other))
    ]
    found = fit_baseline(segments_of(decays), base_model()).fit
    one = replace(found, windows=tuple(replace(window, release=0) for window in found.windows))
    whole, single = with_misfit_errors(found), with_misfit_errors(one)
    return {name: whole.values[name].std / single.values[name].std for name in TRUTH}


def test_errors_grow_by_the_spread_of_releases():
    """A spring that differs by 1 %, many errors of each release, between two of them."""
    assert together(OMEGA * 1.005)["linear_stiffness.k"] > 1.2
    assert together(OMEGA)["linear_stiffness.k"] < 1.5
