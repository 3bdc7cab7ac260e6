"""Frequency and damping against amplitude, held against mathematics: the Duffing spring, viscous and dry friction."""

import numpy as np
import pytest
from decays_in_closed_form import exponential
from scipy.integrate import solve_ivp

import identify
from identify.curves.decay_curve import scatter
from identify.curves.isolated_mode import IsolatedMode
from identify.curves.laid_over import Law
from identify.effects.library import find_effect
from identify.fitting.baseline import fit_baseline
from identify.model.model import Model, Term, base_model
from mocks.generate import draw
from station.views.notebook import draw as picture_of

RATE = 200.0
CUBIC = Term(find_effect("cubic_stiffness"))


def decay(frequency: float, damping: float, seed: int = 1, k3: float = 0.0) -> identify.FreeDecay:
    """Return u'' + 2 d u' + w^2 u + k3 u^3 = 0 let go at 20 mm, with noise of 5 um; in closed form where it is linear."""
    time = np.arange(round(12.0 * RATE)) / RATE
    if k3:
        stiffness = (2.0 * np.pi * frequency) ** 2 + damping**2

        def rates(_, y):
            return [y[1], -2.0 * damping * y[1] - stiffness * y[0] - k3 * y[0] ** 3]

        found = solve_ivp(rates, (0.0, 12.0), [0.02, 0.0], t_eval=time, rtol=1e-9, atol=1e-12)
        u = found.y[0]
    else:
        u = exponential(time, frequency, 0.02, damping)[0]
    return identify.FreeDecay(
        RATE, displacement=u + 5e-6 * np.random.default_rng(seed).standard_normal(len(u))
    )


def law(decays, model: Model) -> Law:
    """Return a model as it is fitted to some releases."""
    prepared = tuple(
        one if isinstance(one, identify.PreparedDecay) else identify.prepare(one) for one in decays
    )
    role = "named" if model.names != base_model().names else "usual"
    return Law.of("usual model" if role == "usual" else "named", role, fit_baseline(prepared, model).fit)


@pytest.fixture(scope="module")
def duffing() -> identify.PreparedDecay:
    return identify.prepare(decay(2.0, 0.12, k3=8e4))


def test_a_viscous_decay_has_level_curves():
    frequency, damping = 2.0, 0.14
    (curve,) = identify.decay_curves(decay(frequency, damping)).releases
    ratio = damping / np.hypot(2.0 * np.pi * frequency, damping)
    inside = 3.0  # standard errors: one point in 370 of noise, and there are two times 24
    assert np.all(np.abs(curve.frequency - frequency) < inside * curve.frequency_std + 1e-4)
    assert np.all(np.abs(curve.damping - ratio) < inside * curve.damping_std + 1e-4)
    assert np.mean(np.abs(curve.damping - ratio) < 2.0 * curve.damping_std) > 0.7


def test_the_curve_of_a_cubic_spring_lies_on_its_backbone(duffing):
    (curve,) = identify.decay_curves(duffing).releases
    linear = (2.0 * np.pi * 2.0) ** 2 + 0.12**2
    backbone = np.sqrt(linear + 0.75 * 8e4 * curve.amplitude**2) / (2.0 * np.pi)
    # The next term of the series is 3/128 (k3 A^2)^2 / k in w^2: 0.03 % at the largest amplitude.
    assert np.all(np.abs(curve.frequency - backbone) < 3.0 * curve.frequency_std + 5e-4 * backbone)
    assert np.ptp(curve.frequency) > 0.1


def test_the_right_law_follows_the_curve_and_the_usual_one_does_not(duffing):
    usual, named = law([duffing], base_model()), law([duffing], base_model().plus(CUBIC))
    assert named.values["cubic_stiffness.k3"] == pytest.approx(8e4, rel=0.02)
    found = identify.decay_curves(duffing, (usual, named))
    curve = found.releases[0]
    off = []
    for laid in found.laws:
        (run,) = laid.curves
        frequency = np.interp(curve.amplitude[::-1], run.amplitude[::-1], run.frequency[::-1])
        off.append(np.abs(frequency - curve.frequency[::-1]))
    assert off[1].max() < 0.004  # Hz, of a curve that moves by 0.15 Hz
    assert off[0].max() > 0.05


def test_each_release_has_its_own_spring_and_damper():
    decays = [decay(2.0, 0.10), decay(2.004, 0.20, seed=2)]
    usual = identify.diagnose(decays, library=(CUBIC.effect,)).laws[:1]
    found = identify.decay_curves(decays, usual)
    for curve, run in zip(found.releases, found.laws[0].curves, strict=True):
        assert run.release == curve.release
        assert np.median(run.frequency) == pytest.approx(np.median(curve.frequency), abs=2e-4)
        assert np.median(run.damping) == pytest.approx(np.median(curve.damping), rel=0.03)


def test_dry_friction_costs_more_the_smaller_the_amplitude():
    sample = draw(None, 0.0, 5)
    (curve,) = identify.decay_curves(
        identify.FreeDecay(sample.rate, sample.displacement, sample.acceleration)
    ).releases
    truth = sample.truth
    omega = np.sqrt(truth["stiffness_per_mass"])
    loss = truth["mu_1"] + 4.0 * truth["mu_0"] / (
        np.pi * omega * curve.amplitude
    )  # equivalent linearisation, 1/s
    large = curve.amplitude > 0.25 * curve.amplitude.max()  # below, a window sees the amplitude halve
    assert curve.damping[large] == pytest.approx(loss[large] / (2.0 * omega), rel=0.05)


def test_the_band_is_the_standard_error_of_independent_values():
    values = np.random.default_rng(3).standard_normal((40, 400)) + 0.02 * np.arange(400)
    found = [np.sqrt(np.mean(scatter(row) ** 2)) for row in values]
    assert np.mean(found) == pytest.approx(1.0, rel=0.03)
    assert np.isnan(scatter(np.ones(3))).all()


def test_what_stands_where_readings_were_lost_does_not_matter():
    time = np.arange(round(12.0 * RATE)) / RATE
    u = exponential(time, 2.0, 0.02, 0.12)[0] + 5e-6 * np.random.default_rng(1).standard_normal(len(time))
    valid = np.ones(len(time), dtype=bool)
    valid[900:960] = False
    window = identify.prepare(identify.FreeDecay(RATE, displacement=u, valid=valid)).window
    mode, lost = IsolatedMode.of(window), ~window.used["displacement"]
    reading = np.array(window.readings["displacement"])
    curves = [mode.curve(np.where(lost, filler, reading)) for filler in (np.nan, 0.3)]
    for name in ("amplitude", "phase", "centre"):
        empty, wrong = (getattr(curve, name) for curve in curves)
        assert np.isfinite(empty).all()
        np.testing.assert_allclose(empty, wrong, rtol=1e-9, atol=1e-12)


def test_too_short_a_release_is_left_out_and_none_at_all_refused():
    long, short = decay(2.0, 0.1), decay(0.36, 0.02)  # 24 cycles, and 4.3
    assert [curve.release for curve in identify.decay_curves([short, long]).releases] == [1]
    with pytest.raises(identify.NotIdentifiable):
        identify.decay_curves(short)


def test_a_notebook_draws_the_curves_with_their_laws(duffing):
    drawn = picture_of(identify.decay_curves(duffing, (law([duffing], base_model()),)))
    left, right = drawn.axes
    assert left.get_ylabel() == "frequency [Hz]"
    assert right.get_ylabel() == "damping ratio [%]"
    assert left.get_xlabel() == "amplitude [mm]"
    assert [text.get_text() for text in drawn.legends[0].get_texts()] == ["release 1", "usual model"]
