"""Coefficients with which a motion runs away: refused in one sentence, or given up for lower orders."""

from contextlib import nullcontext

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from identify.errors import NotIdentifiable
from identify.free_decay import FreeDecay
from identify.preprocessing.aligned_decay import locate_and_align
from identify.signal.averaging import envelope_factors
from identify.wavelet.ridge import exact_decay, observe, simulate_decay
from identify.wavelet.wavelet import identify_wavelet
from mocks.generate import draw


def pendulum(amplitude: float, damping: float, rate: float = 50.0, seconds: float = 60.0) -> FreeDecay:
    """u'' + 37.2 sin u + damping u' = 0, let go at rest; an encoder's noise of 1 mrad."""

    def rates(_, state):
        return state[1], -37.2 * np.sin(state[0]) - damping * state[1]

    time = np.arange(int(rate * seconds)) / rate
    run = solve_ivp(rates, (0.0, time[-1]), (amplitude, 0.0), t_eval=time, rtol=1e-8, atol=1e-10)
    noise = np.random.default_rng(0).normal(0.0, 1e-3, len(time))
    return FreeDecay(rate, run.y[0] + noise, unit="rad")


@pytest.mark.parametrize(
    ("stiffness", "damping"),
    [
        ({1: np.nan}, (0.1, 0.2)),
        ({1: 600.0}, (0.1, np.inf)),
        ({1: 600.0, 3: -1e7}, (0.0, 0.0)),
        ({1: 1e30}, (0.0,)),
    ],
)
def test_coefficients_that_describe_no_decay_are_refused_in_a_sentence(stiffness, damping):
    with pytest.raises(NotIdentifiable, match="would diverge"):
        simulate_decay(0.02, 0.0, stiffness, np.array(damping), 1 / 256, 2048)


@pytest.mark.parametrize(("share", "holds"), [(0.9, False), (1.1, True), (-1.1, True)])
def test_dry_friction_that_would_hold_the_mass_from_the_start_is_refused(share, holds):
    """mu_0 of 2 m/s^2 on a spring of 100 1/s^2 holds 20 mm; other orders of damping may hide that in an envelope."""
    time = np.arange(1000) / 100.0
    decay = 0.02 * np.exp(-0.1 * time) * np.cos(10.0 * time)
    seen = observe(decay, np.ones(1000, dtype=bool), 100.0, 0, 10.0, 1e-6)
    most = 100.0 * 0.02 * envelope_factors(10.0, 0)[0]
    model = np.array([0.02, share * most, 0.1, 0.0, 10.0])  # amplitude, losses, phase, frequency
    with pytest.raises(NotIdentifiable) if holds else nullcontext():
        exact_decay(seen, model, (1,))


def test_a_softening_spring_within_its_well_is_no_runaway():
    # the well of 600 u - 1e5 u^3 ends at 0.077
    decay = simulate_decay(0.02, 0.0, {1: 600.0, 3: -1e5}, np.array([0.0, 0.2]), 1 / 256, 2048)
    assert np.max(np.abs(decay.displacement)) == pytest.approx(0.02, rel=1e-9)  # it starts at its largest


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("seed", [600, 608, 717])
def test_a_spring_that_softens_by_half_is_found_where_its_first_estimate_runs_away(seed):
    # released near the edge of its well; by the averaged equations beyond it
    sample = draw("cubic_stiffness", 0.45, seed, rate=100.0, amplitude=0.0162, mu_0=0.0665)
    recorded = FreeDecay(sample.rate, sample.displacement, sample.acceleration)
    found = identify_wavelet(locate_and_align(recorded).decay)
    cubic = found.stiffness_by_order[3]
    assert abs(cubic.value - sample.truth["parameters"]["k3"]) < 4.0 * cubic.std < 0.01 * abs(cubic.value)


def test_a_pendulum_at_large_angles_shows_the_sine():
    found = identify_wavelet(pendulum(1.3, 0.02))
    linear, cubic = (found.stiffness_by_order[order] for order in (1, 3))
    # sin u = u - u^3/6 + u^5/120 - ...: what is beyond the fifth order shifts the third by 0.3 %
    assert cubic.value == pytest.approx(-linear.value / 6.0, rel=0.02)
    assert cubic.std < 0.02 * abs(cubic.value)


def test_an_envelope_of_which_too_little_is_left_is_refused_in_words() -> None:
    """One sample in sixteen is there: no window of the transform holds enough."""
    time = np.arange(2048) / 256.0
    valid = np.arange(2048) % 16 == 0
    with pytest.raises(NotIdentifiable, match="too many samples are lost"):
        observe(np.exp(-0.3 * time) * np.cos(25.1 * time), valid, 256.0, 0, 25.1, 1e-4)
