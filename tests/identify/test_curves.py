"""Curves of one mode: against closed forms, through the same windows, and what they predict."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import lfilter
from specimens import among, diagnosed

from identify.curves.averaged_law import law_of
from identify.curves.confirm import Curves
from identify.curves.curve_laws import CurveLaws
from identify.curves.decay_curve import DecayCurve
from identify.curves.held_out import cut_by_amplitude, hold_out
from identify.curves.isolated_mode import IsolatedMode, isolated
from identify.curves.likelihood import Added, CurveLikelihood
from identify.diagnosis.diagnose import diagnose
from identify.effects.force_effect import ForceEffect
from identify.effects.library import LIBRARY, find_effect
from identify.effects.user import own_effect
from identify.errors import NotIdentifiable
from identify.fitting.initial_values import scales_of, term_starts
from identify.free_decay import FreeDecay
from identify.judging.suspects import candidate_terms
from identify.model.equivalent_linearisation import average
from identify.model.model import Term, base_model
from identify.preprocessing.prepared_decay import prepare
from mocks.generate import draw

W = 2.0 * np.pi * 1.3
RATE = 40.0


def displacement_only(name, strength, seed, **setting):
    """Return a release of the double without its second channel: its floor can only be guessed."""
    sample = draw(name, strength, seed, **setting)
    return prepare(FreeDecay(sample.rate, displacement=sample.displacement))


def confirmed(decays):
    terms = candidate_terms(base_model(), LIBRARY, decays[0].window)
    return Curves(decays, base_model(), {}, terms, scales_of(decays[0], {})).confirmation


def decaying(seconds=40.0, loss=0.08, noise=0.0, seed=1):
    time = np.arange(int(seconds * RATE)) / RATE
    clean = 0.1 * np.exp(-0.5 * loss * time) * np.cos(W * time + 0.4) + 0.02
    return clean + noise * np.random.default_rng(seed).standard_normal(len(time))


def window_of(values, rate=RATE):
    return prepare(FreeDecay(rate, displacement=values)).window


def test_a_viscous_decay_has_flat_curves_at_its_loss_and_frequency():
    window = window_of(decaying())
    mode = IsolatedMode.of(window)
    curve = mode.curve(np.asarray(window.readings["displacement"]))
    assert curve.loss == pytest.approx(
        0.08, rel=1e-3
    )  # the window's polynomial in time against e^(-loss t/2)
    assert curve.frequency == pytest.approx(W, rel=1e-5)
    assert curve.amplitude == pytest.approx(0.1 * np.exp(-0.04 * curve.time), rel=1e-3)
    assert curve.centre == pytest.approx(0.02, abs=1e-5)


def test_the_curve_is_linear_in_the_reading_so_that_a_prediction_passes_the_same_windows():
    window = window_of(decaying(noise=1e-4))
    mode = IsolatedMode.of(window)
    reading = np.asarray(window.readings["displacement"])
    once, twice = mode.curve(reading), mode.curve(2.0 * reading)
    assert twice.amplitude == pytest.approx(2.0 * once.amplitude, rel=1e-12)
    assert np.diff(twice.phase) == pytest.approx(np.diff(once.phase), abs=1e-12)


def test_acceleration_gives_the_curve_of_the_displacement():
    values = decaying() - 0.02
    window = window_of(values)
    curve = IsolatedMode.of(window).curve(np.asarray(window.readings["displacement"]))
    time = np.arange(len(values)) / RATE
    # u'' of A e^{-ct} cos(wt + p), in closed form
    c = 0.04
    second = (
        0.1
        * np.exp(-c * time)
        * ((c * c - W * W) * np.cos(W * time + 0.4) + 2 * c * W * np.sin(W * time + 0.4))
    )
    other = prepare(FreeDecay(RATE, acceleration=second)).window
    seen = IsolatedMode.of(other).curve(np.asarray(other.readings["acceleration"]))
    assert not seen.has_centre
    size = np.interp(seen.time, curve.time, curve.amplitude)
    inside = (seen.time > curve.time[0]) & (seen.time < curve.time[-1])
    assert seen.amplitude[inside] == pytest.approx(size[inside], rel=5e-3)


def test_a_record_of_two_cycles_has_no_curve():
    window = window_of(decaying())
    with pytest.raises(NotIdentifiable):
        IsolatedMode.of(window.part(slice(int(2 * RATE / 1.3))))


def test_beats_and_a_drive_are_seen_and_a_decay_is_neither():
    time = np.arange(40.0)
    level = np.zeros(40)

    def curve(amplitude):
        return DecayCurve(time, amplitude, 8.0 * time, level, level)

    decay = curve(np.exp(-0.05 * time))
    beating = curve(np.exp(-0.05 * time) * (1.0 + 0.6 * np.cos(0.5 * time)))
    driven = curve(1.0 - 0.6 * np.exp(-0.4 * time))
    assert (decay.beats, decay.driven) == (False, False)
    assert beating.beats
    assert not beating.driven
    assert driven.driven
    assert not curve(0.4 + 0.6 * np.exp(-0.4 * time)).driven  # it may be free, and its damping fade
    assert not curve((1.0 + 90.0 * time) ** -0.2).driven  # damping of the sixth power of the velocity


def test_a_decay_that_ends_at_a_level_because_its_damping_fades_is_named_and_not_called_driven():
    w, times = 2.0 * np.pi * 2.0, np.arange(0.0, 40.0, 0.01)
    free = solve_ivp(
        lambda t, y: (y[1], -w * w * y[0] - (np.exp(-t / 4.0) + 0.005) * y[1]),
        (0.0, 40.0), (0.02, 0.0), t_eval=times, rtol=1e-9, atol=1e-12,
    )  # fmt: skip
    noise = 2e-5 * np.random.default_rng(5).standard_normal(len(times))
    found = diagnosed(FreeDecay(100.0, free.y[0] + noise))
    assert found.named == ("fading_damping",)


def test_amplitudes_whose_product_is_too_small_a_number_have_a_mean_all_the_same():
    time, none = np.arange(3.0), np.zeros(3)
    curve = DecayCurve(time, np.array([1e-3, 1e-300, 1e-300]), 8.0 * time, none, none)
    assert np.log(curve.between) == pytest.approx(np.log([10.0**-151.5, 1e-300]))


def test_a_motion_that_beats_to_the_end_about_one_amplitude_is_driven_and_a_beat_that_falls_is_not():
    time = np.arange(90.0)
    beat = 0.3 * np.cos(2.0 * np.pi * time / 6.0)

    def curve(amplitude):
        return DecayCurve(time, amplitude, 8.0 * time, 0.0 * time, 0.0 * time)

    driven = curve(0.6 + beat + 1.2 * np.exp(-0.1 * time) * np.cos(2.0 * np.pi * time / 11.0) ** 2)
    assert driven.driven
    assert driven.beats_late
    growing = curve(np.exp(0.05 * time))
    assert growing.grows
    assert growing.driven
    assert not driven.grows
    assert not curve((0.6 + beat) * np.exp(-0.02 * time)).driven
    assert not curve((0.6 + beat) / (1.0 + 0.03 * time)).driven
    assert not curve(np.exp(0.05 * time)).part(slice(5)).driven  # the first half of a beat rises, too


def test_readings_lost_at_regular_distances_do_not_change_where_the_curve_looks():
    """A camera that drops five of ten frames: the gaps are no oscillation."""
    time = np.arange(420) / 30.0
    reading = 0.4 * np.exp(-0.05 * time) * np.cos(2.0 * np.pi * 1.34 * time)
    decay = FreeDecay(30.0, displacement=reading + 0.002 * np.random.default_rng(2).standard_normal(420),
                      valid=np.arange(420) % 10 >= 5)  # fmt: skip
    (release,) = isolated((prepare(decay),))
    assert release.curve.frequency == pytest.approx(2.0 * np.pi * 1.34, rel=0.02)
    assert not release.curve.driven


def test_a_record_is_cut_in_three_equal_ratios_of_amplitude_and_a_short_one_in_two():
    time = np.arange(60.0)
    whole = DecayCurve(time, np.exp(-0.05 * time), 8.0 * time, 0 * time, 0 * time)
    large, middle, small = (whole.part(cut) for cut in cut_by_amplitude(whole))
    assert large.amplitude[-1] == middle.amplitude[0] == pytest.approx(np.exp(-0.05 * 59 / 3), rel=0.03)
    assert middle.amplitude[-1] == small.amplitude[0] == pytest.approx(np.exp(-0.05 * 118 / 3), rel=0.03)

    def lengths(points):
        return [len(range(points)[cut]) for cut in cut_by_amplitude(whole.part(slice(points)))]

    assert lengths(16) == [6, 6, 6]
    assert lengths(15) == [8, 8]
    assert lengths(10) == [10]


@pytest.mark.parametrize(
    "name", [pytest.param("cubic_stiffness", marks=pytest.mark.slow), "quadratic_damping"]
)
def test_an_effect_predicts_the_small_amplitudes_and_is_named(name):
    found = confirmed((displacement_only(name, 0.03, 11, amplitude=0.02, mu_0=0.01),))
    assert found.one_record
    assert name in found.mentioned
    if name == "quadratic_damping":
        assert found.names[0] == name
        assert found.found.typical("motion") < 0.3 * found.usual.typical("motion")
        assert found.effects[0].nats > 6.0
    else:
        assert found.names == (name,)


def test_nothing_hidden_confirms_nothing():
    found = confirmed((displacement_only(None, 0.0, 3, amplitude=0.02),))
    assert found.names == ()
    assert found.usual.typical("motion") < 0.5


def test_what_three_releases_share_predicts_the_one_left_out():
    k3 = {"cubic_stiffness": {"k3": 1.2e5}}
    decays = tuple(
        displacement_only("cubic_stiffness", 0.03, 20 + i, amplitude=a, mu_0=0.02, parameters=k3)
        for i, a in enumerate((0.02, -0.015, 0.01))
    )
    found = confirmed(decays)
    assert not found.one_record
    assert found.parts == 3
    assert found.names[0] == "cubic_stiffness"
    assert found.effects[0].strength == pytest.approx(1.2e5, rel=0.05)
    assert found.effects[0].nats > 20.0


def test_strengths_keep_their_bounds():
    """Loss that falls with the amplitude (dry friction) asks for negative drag: it gets none, and friction instead."""
    decay = displacement_only(None, 0.0, 5, amplitude=0.02, mu_0=0.2, mu_1=0.02)
    terms = candidate_terms(base_model(), (find_effect("quadratic_damping"),), decay.window)
    laws = CurveLaws.of(isolated([decay]), base_model(), {}, terms, scales_of(decay, {}))
    likelihood = CurveLikelihood(laws)
    usual = likelihood.usual()
    drag = Added().and_law(3, float(laws.natural[3]))
    products = likelihood.products(likelihood.observed, [3])
    free, _ = likelihood._solved(products, drag, usual.settings, ())
    found = likelihood.fitted(products, drag, usual.settings)
    assert min(free[1:]) < 0.0  # else there is nothing to keep
    assert min(found.shared[1:]) >= 0.0
    assert found.shared[1] == pytest.approx(0.2, rel=0.05)


def test_what_is_predicted_of_a_part_was_not_fitted_to_it():
    """The third release has twice the dry friction: the others do not predict it. Its own spring and damper are refitted."""
    decays = tuple(
        displacement_only(None, 0.0, 7 + i, amplitude=0.02, mu_0=mu_0, mu_1=0.1, stiffness=stiffness)
        for i, (mu_0, stiffness) in enumerate(((0.1, 614.0), (0.1, 614.0), (0.2, 617.0)))
    )
    laws = CurveLaws.of(isolated(decays), base_model(), {}, (), scales_of(decays[0], {}))
    likelihood = CurveLikelihood(laws)
    third = hold_out(likelihood, likelihood.usual()).predicted[2]
    assert third.envelope > 3.0
    assert third.phase < 1.0  # a spring of its own by half a percent: 8 rad over 8 s of 4 Hz


@pytest.mark.slow
def test_a_guessed_floor_that_is_reached_keeps_its_name():
    found = diagnosed(displacement_only("end_stop", 0.03, 31, amplitude=0.02, mu_0=0.02))
    assert found.named == ("end_stop",)


def test_a_record_that_grows_up_to_its_last_cycles_has_no_curve():
    time = np.arange(int(6.0 / (W / (2.0 * np.pi)) * RATE)) / RATE
    pushed = np.exp(0.2 * time) * np.cos(W * time)
    with pytest.raises(NotIdentifiable, match="too few cycles"):
        IsolatedMode.of(window_of(pushed))


def test_windows_in_a_gap_say_nothing_and_are_left_out():
    values = decaying()
    window = window_of(values)
    used = np.ones(len(window), bool)
    used[int(10.0 * RATE) : int(13.0 * RATE)] = False
    holed = window.with_(used={"displacement": used})
    mode = IsolatedMode.of(holed)
    curve = mode.curve(np.where(used, window.readings["displacement"], 7.0))
    assert np.diff(mode.centre).max() > 2.0
    assert curve.loss == pytest.approx(0.08, rel=1e-2)
    assert curve.frequency == pytest.approx(W, rel=1e-4)


@pytest.mark.parametrize("size", [1e-3, 1.0, 500.0])
def test_a_law_is_the_same_in_all_units(size):
    """A force k2 u^2 moves the centre by -k2 A^2/(2 w^2), and w^2 by a square of k2, which is no multiple of it."""
    term = next(
        t
        for t in candidate_terms(base_model(), LIBRARY, window_of(decaying()))
        if t.effect.name == "quadratic_stiffness"
    )
    grid = size * np.array([0.1, 0.3, 1.0])
    law = law_of(term, {}, W, grid, 40.0)
    assert law.centre == pytest.approx(-(grid**2) / (2.0 * W**2), rel=1e-6)
    assert np.abs(law.signatures[0].stiffening).max() < 1e-9 * size


@pytest.mark.parametrize("tau", [5.0, 15.0, 60.0])
def test_a_stiffness_that_settles_is_followed_along_the_record(tau):
    window = window_of(decaying())
    curve = IsolatedMode.of(window).curve(np.asarray(window.readings["displacement"]))
    law = law_of(Term(find_effect("settling_stiffness")), {"tau": tau}, W, np.array([0.02, 0.05, 0.1]), 40.0)
    loss, stiffening, centre = law.along(curve)
    assert stiffening == pytest.approx(W**2 * (1.0 - np.exp(-curve.clock / tau)), abs=0.03 * W**2)
    assert np.abs(loss).max() < 1e-9 * W**2
    assert np.abs(centre).max() < 1e-9


def test_what_is_said_to_move_with_the_clock_does_and_nothing_else():
    grid = np.geomspace(0.005, 0.02, 5)
    scales = scales_of(displacement_only(None, 0.0, 5, amplitude=0.02), {})
    for effect in LIBRARY:
        if not isinstance(effect, ForceEffect) or effect.line or effect.linear_part is not None:
            continue
        term = Term(effect, effect.variants[0])
        inner = term_starts(term, scales)[0]
        shared = {name: rough(24.8) for name, rough in effect.shared_parameters.items()}
        values = term.held_values | inner | {effect.strength.name: 1.0} | shared
        early, late = (average(effect, values, 24.8, grid, time=t) for t in (0.0, 7.0))
        moved = not np.allclose(early.stiffening, late.stiffening) or not np.allclose(
            early.damping, late.damping
        )
        assert moved == effect.of_time, effect.name
    assert own_effect("loosens", "k*exp(-t/tau)*u").of_time
    assert not own_effect("hardens", "k*u**3").of_time


def test_a_name_that_one_record_gives_says_which_law_of_time_would_do_as_well():
    """Drag on a spring, an amplitude that falls to a third: a damper that fades would follow it, too."""
    time, random = np.arange(900) / 25.0, np.random.default_rng(3)
    run = solve_ivp(
        lambda t, y: [y[1], -30.0 * y[0] - 0.02 * y[1] - 0.35 * y[1] * abs(y[1])],
        (0.0, 36.0), [0.1, 0.0], t_eval=time, rtol=1e-9, atol=1e-11,
    )  # fmt: skip
    erring = run.y[0] + lfilter([2e-4], [1.0, -0.8], random.standard_normal(900))
    rivals = ("fading_damping", "position_dependent_damping", "cubic_stiffness", "hysteresis")
    read = FreeDecay(25.0, erring + 1e-4 * random.standard_normal(900))
    found = diagnose(read, library=among("quadratic_damping", *rivals))
    assert found.named == ("quadratic_damping",)
    assert "fading_damping" in found.suspects[0].rivals
