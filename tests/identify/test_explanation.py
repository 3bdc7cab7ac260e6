"""What a diagnosis says: percent of the motion where the floor is a guess, and what to record of a driven motion."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from identify.diagnosis import explain
from identify.diagnosis.diagnose import Diagnosis, diagnose
from identify.effects.library import find_effect
from identify.fitting.model_error import motion_percent
from identify.free_decay import FreeDecay
from mocks.generate import draw

FEW = (find_effect("quadratic_damping"),)
SPRING_AND_DRAG = (*FEW, find_effect("cubic_stiffness"), find_effect("settling_stiffness"))


@pytest.fixture(scope="module")
def short():
    """Seven cycles of a cubic spring in one channel: too few for a curve that predicts."""
    sample = draw("cubic_stiffness", 0.1, 8, amplitude=0.02)
    cut = slice(None, int(sample.rate * 2.4))
    return diagnose(FreeDecay(sample.rate, displacement=sample.displacement[cut]), library=FEW)


def test_standard_errors_that_are_stated_are_those_of_the_misfit_above_the_floor(short):
    stated = short.baseline.stated(short.baseline.fit)
    assert not short.baseline.at_floor
    assert (
        stated.parameters["linear_stiffness.k"].std
        > 3.0 * short.baseline.fit.parameters["linear_stiffness.k"].std
    )
    assert np.all(stated.theta == short.baseline.fit.theta)


def test_a_suspects_parameters_have_the_errors_to_state_and_are_found_once(short):
    suspect = short.suspects[0]
    stated = short.baseline.stated(suspect.fit)
    assert suspect.parameters["c2"].value == suspect.fit.parameters["quadratic_damping.c2"].value
    assert suspect.parameters["c2"].std == stated.values["quadratic_damping.c2"].std
    assert suspect.stated is suspect.stated


def test_what_is_left_is_said_in_percent_of_the_motion_where_the_floor_is_a_guess(short):
    assert short.verdict == "unknown_effect"
    assert "% of the motion (" in short.explanation
    assert "fewer than about twelve cycles" in short.explanation


def pendulum() -> FreeDecay:
    """A filmed pendulum let go at 1.4 rad, viscous and dry losses, eight cycles at 30 frames/s."""
    time = np.arange(360) / 30.0

    def rates(_, y):
        return [y[1], -0.04 * y[1] - 0.3 * np.tanh(y[1] / 0.01) - 17.0 * np.sin(y[0])]

    u = solve_ivp(rates, (0.0, 12.0), [1.4, 0.0], t_eval=time, rtol=1e-8, atol=1e-10).y[0]
    return FreeDecay(30.0, displacement=u + 2e-3 * np.random.default_rng(1).standard_normal(360), unit="rad")


def test_effects_that_each_explain_nearly_all_are_said_and_only_the_rest_has_no_name():
    names = ("bilinear_stiffness", "settling_stiffness", "time_varying_stiffness")
    found = diagnose(pendulum(), library=tuple(find_effect(name) for name in names))
    assert found.verdict == "unknown_effect"
    percent = motion_percent(next(s.fit for s in found.suspects if s.effect.name == "settling_stiffness"))
    leaves = {s.effect.name: f"{s.error_after**0.5:.3g} times" for s in found.suspects}
    assert f"Settling stiffness would leave {percent:.3g} % of the motion" in found.explanation
    said = f", time varying stiffness {leaves['time_varying_stiffness']}; noise alone would leave"
    assert said in found.explanation
    assert "None of these comes down to the noise" in found.explanation
    assert "and no effect can be named" not in found.explanation


LINES = ("mains_hum", "harmonic_forcing")


def hummed(size: float, lines: tuple[str, ...] = LINES) -> Diagnosis:
    """Return the diagnosis of a decay of 0.3 rad with noise of 2.5 mrad and a line of some size (rad) at 23 Hz."""
    rng, time = np.random.default_rng(2), np.arange(800) / 50.0
    u = 0.3 * np.exp(-0.05 * time) * np.cos(2 * np.pi * 0.95 * time) + 2.5e-3 * rng.standard_normal(800)
    u += size * np.sin(2 * np.pi * 23.15 * time)
    names = (*lines, "cubic_stiffness", "quadratic_damping")
    return diagnose(FreeDecay(50.0, displacement=u), library=tuple(find_effect(name) for name in names))


def test_what_is_named_at_the_floor_is_said_to_be_small_and_not_held_against_the_whole_library():
    found = hummed(1.9e-3, ("mains_hum",))
    assert found.verdict == "sensor_fault"
    assert "reaches the floor without it, too: the named effect is small" in found.explanation
    assert "cubic stiffness" not in found.explanation


def test_a_line_far_above_the_motion_of_one_channel_may_be_hum_or_a_force():
    found = hummed(1.9e-3)
    assert found.named == ("mains_hum",)
    assert found.suspects[0].rivals == ("harmonic_forcing",)
    leaves = {s.effect.name: s.fit.reduced for s in found.suspects}
    assert leaves["harmonic_forcing"] == pytest.approx(leaves["mains_hum"], rel=1e-3)
    assert "does not distinguish it from harmonic forcing" in found.explanation


def test_a_line_below_what_is_worth_a_name_is_a_remark():
    found = hummed(1.1e-3)
    assert found.verdict == "nothing_missing"
    assert "The displacement has a line at 23.1" in found.explanation
    assert "too small to be named" in found.explanation


@pytest.mark.parametrize(
    ("kind", "sure", "before", "after", "told"),
    [
        (
            "sensor",
            False,
            9.98,
            9.80,
            "What is named explains 4 % of the residual: 9.80 % of the motion remains",
        ),
        ("sensor", False, 9.98, 9.975, "What is named explains hardly any of the residual"),
        ("sensor", False, 9.98, 3.0, ""),  # most of it
        ("sensor", False, 0.5, 0.4, ""),  # little is left
        ("sensor", True, 9.98, 9.80, ""),
        ("physics", False, 9.98, 9.80, ""),
    ],
)
def test_a_sensors_fault_that_is_little_of_what_a_guessed_floor_excuses_is_told(
    monkeypatch, kind, sure, before, after, told
):
    monkeypatch.setattr(explain, "motion_percent", lambda found: found)
    monkeypatch.setattr(explain, "removed_percent", lambda one, other: np.sqrt(one**2 - other**2))
    baseline = SimpleNamespace(fit=before, floor_is_sure=sure)
    words = explain._hardly_any_of_it(baseline, SimpleNamespace(kind=kind), SimpleNamespace(fit=after))
    assert words.strip().startswith(told) if told else words == ""


def test_of_a_channel_that_the_displacement_does_not_show_the_misfit_is_told_that_falls():
    sample = draw("quadratic_damping", 1e-6, 8, amplitude=0.02)
    drift = 0.01 * np.arange(len(sample.displacement)) / sample.rate
    channels = {"displacement": sample.displacement, "acceleration": sample.acceleration + drift}
    found = diagnose(FreeDecay(sample.rate, **channels), library=(find_effect("offset_drift"),))
    told = re.search(r"the residual from ([\d.]+) to ([\d.]+) % of the acceleration", found.explanation)
    assert float(told[2]) < 0.7 * float(told[1])


def test_what_is_on_no_card_is_not_the_next_best():
    def suspect(name, left, plausible=True):
        effect = find_effect(name)
        return SimpleNamespace(
            effect=effect, error_after=left, plausible=plausible, corrected=None, fit=None, rivals=()
        )

    baseline = SimpleNamespace(fit=None, reduced=lambda fit: 100.0, adequate=lambda fit: False)
    others = (suspect("dahl_friction", 1.1, plausible=False), suspect("cubic_damping", 50.5))
    words = explain._alternatives(baseline, suspect("quadratic_damping", 1.0), others)
    assert words.startswith("The next best, cubic damping, would explain 50 % of it")


@pytest.mark.parametrize("seed", [1, 2])
def test_what_a_record_says_that_it_would_have_shown_it_shows(seed: int):
    def told(strength: float, number: int) -> Diagnosis:
        hidden, parameters = (
            ("cubic_stiffness", {"cubic_stiffness": {"k3": strength}}) if strength else (None, {})
        )
        made = {
            "stiffness": 600.0,
            "mu_0": 0.1,
            "mu_1": 0.3,
            "noise_displacement": 3e-6,
            "noise_acceleration": 0.01,
        }
        sample = draw(
            hidden, 0.02 if hidden else 0.0, 10 * seed + number, amplitude=0.02, **made, parameters=parameters
        )
        return diagnose(
            FreeDecay(sample.rate, sample.displacement, sample.acceleration), library=SPRING_AND_DRAG
        )

    nothing = told(0.0, 0)
    assert nothing.verdict == "nothing_missing"
    found = re.search(r"cubic stiffness beyond ±([\d.]+) ", nothing.explanation)
    assert found
    shown = [told(sign * float(found[1]), number).verdict for number, sign in enumerate((1.0, -1.0), 1)]
    assert "nothing_missing" not in shown
