"""Long and fast records: every reading counts, in few pieces, within little memory."""

import tracemalloc

import numpy as np
import pytest
from decays_in_closed_form import exponential

from identify.diagnosis.diagnose import diagnose
from identify.effects.library import find_effect
from identify.fitting.baseline import fit_baseline
from identify.fitting.segments import drifts, segments, what_was_used
from identify.free_decay import FreeDecay
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import prepare
from identify.signal.integration import slow_part
from mocks.generate import draw

FREQUENCY, DECAY = 3.94, 0.02
STIFFNESS = (2 * np.pi * FREQUENCY) ** 2 + DECAY**2  # per unit mass, of A e^(-d t) cos(w t)
NOISE = (5e-6, 1e-2)


def viscous(seconds: float, rate: float = 256.0, seed: int = 0, wander: float = 0.0) -> FreeDecay:
    """Both channels of a viscous decay in mid-motion; `wander` (rad) is the standard deviation of its phase in a second."""
    random = np.random.default_rng(seed)
    time = np.arange(int(seconds * rate)) / rate
    steps = random.normal(0.0, wander / np.sqrt(rate), len(time))
    moved = time + np.cumsum(steps) / (2 * np.pi * FREQUENCY)
    u, _, a = exponential(moved, FREQUENCY, decay=DECAY)
    return FreeDecay(rate, u + random.normal(0, NOISE[0], len(u)), a + random.normal(0, NOISE[1], len(a)))


def stiffness_of(decay: FreeDecay):
    fit = fit_baseline(segments(prepare(decay)), base_model().minus("coulomb_friction")).fit
    return fit.values["linear_stiffness.k"]


def test_the_pieces_of_a_long_record_cover_it_without_a_gap():
    whole = prepare(viscous(40.0))
    pieces = segments(whole)
    joined = np.concatenate([piece.window.readings["displacement"] for piece in pieces])
    assert np.array_equal(joined, whole.window.readings["displacement"])
    assert {piece.share for piece in pieces} == {1.0}


def test_what_is_not_fitted_of_a_very_long_record_is_said():
    whole = prepare(viscous(100.0, rate=64.0))
    pieces = segments(whole)
    share = sum(len(piece.window) for piece in pieces) / len(whole.window)
    assert share < 0.7  # 394 cycles
    assert f"{100 * share:.3g} % of their motion" in what_was_used(pieces)
    assert what_was_used((prepare(viscous(8.0)),)) == ""


def test_a_phase_that_keeps_in_step_leaves_the_pieces_long_and_one_that_wanders_does_not():
    steady, wandering = prepare(viscous(40.0)), prepare(viscous(40.0, wander=3e-3))
    assert not drifts(steady)
    assert drifts(wandering)
    assert len(segments(steady)) < len(segments(wandering))
    assert not drifts(prepare(viscous(1.3)))  # one cycle between the ends tells nothing


@pytest.mark.slow
def test_two_more_seconds_do_not_make_the_stiffness_less_certain():
    shorter, longer = stiffness_of(viscous(15.0)), stiffness_of(viscous(17.0))
    assert longer.std <= shorter.std
    assert abs(longer.value - STIFFNESS) < 4.0 * longer.std


@pytest.mark.slow
def test_a_fast_record_is_averaged_and_its_noise_falls_with_the_root():
    rate = 5120.0
    prepared = prepare(viscous(8.0, rate=rate))
    assert prepared.block == round(rate / prepared.window.rate) > 10
    for channel, sigma in zip(("displacement", "acceleration"), NOISE, strict=True):
        # the sixth differences of 40 000 readings know their noise to a per cent
        assert prepared.noise[channel].std == pytest.approx(sigma / np.sqrt(prepared.block), rel=0.03)
    fit = fit_baseline((prepared,), base_model().minus("coulomb_friction")).fit
    stiffness, damping = fit.values["linear_stiffness.k"], fit.values["viscous_damping.mu_1"]
    assert abs(stiffness.value - STIFFNESS) < 4.0 * stiffness.std
    assert abs(damping.value - 2 * DECAY) < 4.0 * damping.std
    assert fit.reduced == pytest.approx(1.0, abs=0.1)


def test_the_slow_part_of_a_thousand_cycles_is_found_in_little_memory():
    rate, frequency = 640.0, 40.0
    time = np.arange(int(25.0 * rate)) / rate
    drift = 0.3 * time + 0.02 * time**2
    u, _, _ = exponential(time, frequency)
    tracemalloc.start()
    found = slow_part(u + drift, rate, frequency, np.ones(len(time), dtype=bool))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert (
        np.max(np.abs(found.value - drift)) < 1e-4 * 0.02
    )  # of the amplitude: its decay within a knot's two periods
    assert peak < 60e6  # dense it would be 200 MB, and 16 times as much for four times the length


def test_the_slow_part_bridges_a_gap():
    rate = 256.0
    time = np.arange(2048) / rate
    drift = 0.3 * time + 0.02 * time**2
    there = (time < 3.0) | (time > 3.3)
    u, _, _ = exponential(time, FREQUENCY)
    found = slow_part(np.where(there, u + drift, 99.0), rate, FREQUENCY, there)
    assert np.max(np.abs(found.value - drift)) < 1e-4 * 0.02


@pytest.mark.slow
def test_a_stop_that_no_curve_shows_is_found_by_free_run_in_a_long_record_of_one_channel():
    sample = draw("end_stop", 0.5, 1, seconds=24.0, mu_0=0.02, mu_1=0.1)
    rivals = ("end_stop", "cubic_stiffness", "freeplay", "quadratic_damping", "hysteresis")
    found = diagnose(
        FreeDecay(sample.rate, displacement=sample.displacement),
        library=tuple(find_effect(name) for name in rivals),
    )
    assert len(found.baseline.fit.windows) > 1
    assert found.confirmation is not None
    assert not found.confirmation.effects
    assert found.named == ("end_stop",)
    gap = found.suspects[0].parameters["gap"]
    assert gap.value == pytest.approx(sample.truth["parameters"]["gap"], abs=5.0 * gap.std)
