"""Far from the noise fewer readings are compared in longer steps; what a fit states is of all readings."""

import numpy as np
import pytest
from releases import drawn

from identify.effects.library import find_effect
from identify.fitting.fit import fit
from identify.fitting.initial_values import initial_values
from identify.fitting.problem import Problem
from identify.model.model import Term, base_model
from identify.preprocessing.fit_window import FitWindow
from identify.signal.coloured_noise import Colour, Component


def window(n: int, colour: dict[str, Colour]) -> FitWindow:
    """A window of one channel, read at 128 Hz in noise of 1, that begins after 4 readings of a lead."""
    used = np.arange(n) >= 4
    return FitWindow(
        128.0,
        0.0,
        {"displacement": np.zeros(n)},
        {"displacement": used},
        {"displacement": 1.0},
        4,
        colour=colour,
    )


@pytest.mark.parametrize(
    "colour",
    [{}, {"displacement": Colour((Component(5.0, 0.2),))}, {"displacement": Colour((Component(3.0, 2.0),))}],
)
def test_a_misfit_weighs_as_much_by_every_fourth_reading_as_by_all(colour):
    whole = window(4096, colour)
    thinned = whole.thinned(4)
    assert len(thinned) == 1024
    assert thinned.rate == 32.0
    misfit = 30.0 * np.cos(2.0 * np.pi * 1.7 * whole.clock)
    by_all, by_fourth = whole.compared("displacement", misfit), thinned.compared("displacement", misfit[::4])
    # 19 readings a cycle after thinning; between two of them a drift of the noise changes a little, which whitening weighs.
    assert by_fourth @ by_fourth == pytest.approx(by_all @ by_all, rel=0.1)


def test_a_driven_window_keeps_all_its_readings():
    driven = window(256, {}).with_(force=np.ones(256))
    assert driven.thinned(4) is driven


def problems(name, seed=7100, **inner):
    prepared, truth = drawn(name, 0.03, seed)
    term = Term(find_effect(name))
    model = base_model().plus(term)
    start = initial_values((prepared,), model, term.by_name(inner))
    whole, far = (Problem(model, (prepared.window,), prepared.frequency, far=far) for far in (False, True))
    return whole, far, np.clip(whole.theta(start), whole.low, whole.high), prepared, truth


def test_far_off_half_of_the_readings_say_what_all_do():
    whole, far, theta, *_ = problems("cubic_stiffness")
    theta[whole.index["linear_stiffness.k"]] *= (
        1.003  # a tenth of a turn after 31 cycles: some 100 times the noise
    )
    all_readings, half = whole.residuals(theta), far.residuals(theta)
    assert len(half) <= 0.51 * len(all_readings)
    assert half @ half > 100.0 * len(all_readings)
    assert half @ half == pytest.approx(all_readings @ all_readings, rel=0.02)


@pytest.mark.parametrize("name", ["dahl_friction", "hysteresis"])
def test_friction_that_gives_way_over_a_long_path_takes_longer_steps_far_off_and_moves_alike(name):
    inner = {"dahl_friction": "ud", "hysteresis": "uy"}[name]
    whole, far, theta, prepared, _ = problems(name, **{inner: 0.3 * 0.02})
    assert far.substeps(theta, 0) < 2 * whole.substeps(theta, 0)  # of two samples
    near, rough = whole.respond(theta, 0).displacement[::2], far.respond(theta, 0).displacement
    # Longer steps err by less than the misfit that they are for, 1e-3 of the amplitude.
    assert np.max(np.abs(rough - near[: len(rough)])) < 1e-3 * prepared.amplitude


def test_friction_that_gives_way_over_a_sixtieth_of_the_amplitude_keeps_its_fine_steps():
    whole, far, theta, prepared, _ = problems("dahl_friction", ud=1e-3)
    theta[whole.index["dahl_friction.ud"]] = prepared.amplitude / 60.0
    assert far.substeps(theta, 0) == 2 * whole.substeps(theta, 0)  # of two samples
    assert np.isfinite(far.residuals(theta)).all()


def test_a_fit_that_stays_far_off_is_that_of_all_readings():
    prepared, _ = drawn("cubic_stiffness", 0.03, 7100)
    model = base_model()
    found = fit(model, (prepared.window,), initial_values((prepared,), model, {}), prepared.frequency)
    assert found.reduced > 100.0
    assert found.windows[0] is prepared.window
    misfit = Problem(model, (prepared.window,), prepared.frequency).residuals(found.theta)
    assert found.chi_square == pytest.approx(misfit @ misfit, rel=1e-3)
