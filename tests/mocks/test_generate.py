"""Drawn releases: the strengths are met, the truth tells all, the seed decides all."""

import json
from pathlib import Path

import numpy as np
import pytest

from mocks import generate
from mocks.forces import BETWEEN_THE_NAMES, OUTSIDE_THE_LIBRARY, PARAMETERS, Effect
from mocks.generate import PHYSICS, draw
from mocks.sensor_faults import SENSOR_FAULTS
from mocks.testbed import Bench, Release, simulate, simulate_channels

HIDDEN = Path(__file__).parents[1] / "data" / "hidden"

#: The rows of the table of effects.
LIBRARY = [
    "linear_stiffness",
    "viscous_damping",
    "coulomb_friction",
    "quadratic_damping",
    "cubic_damping",
    "position_dependent_damping",
    "stribeck_friction",
    "position_dependent_friction",
    "cubic_stiffness",
    "quadratic_stiffness",
    "quintic_stiffness",
    "signed_quadratic_stiffness",
    "end_stop",
    "impact_with_loss",
    "freeplay",
    "bilinear_stiffness",
    "hysteresis",
    "dahl_friction",
    "maxwell_element",
    "second_mass",
    "time_varying_stiffness",
    "settling_stiffness",
    "fading_damping",
    "fading_friction",
    "harmonic_forcing",
]


def rebuilt(truth: dict) -> tuple[np.ndarray, np.ndarray]:
    """The noiseless channels of a truth, by the testbed."""
    names = truth["hidden"].split("+")
    parameters = truth["parameters"] if len(names) > 1 else {names[0]: truth["parameters"]}
    effects = tuple(Effect(n, dict(parameters[n])) for n in names if n in PARAMETERS)
    bench = Bench(truth["stiffness_per_mass"], truth["mu_0"], truth["mu_1"], effects)
    clock = np.arange(2240) / 256.0 - truth["released_at_s"]
    release = Release(truth["from_m"], 0.0, truth["hand_s"])
    return simulate_channels(bench, release, clock - truth["displacement_late_s"], clock)


def test_every_effect_and_every_sensor_fault_of_the_table_can_be_hidden():
    assert set(PHYSICS) == set(LIBRARY)
    assert set(SENSOR_FAULTS) == {
        "channel_lag", "channel_gain", "offset_drift", "clipping", "ac_coupling", "mains_hum", "dropouts",
        "sensor_nonlinearity", "sensor_bandwidth",
    }  # fmt: skip
    assert len(OUTSIDE_THE_LIBRARY) >= 5
    assert set(generate.everything()) == {
        *LIBRARY, *OUTSIDE_THE_LIBRARY, *BETWEEN_THE_NAMES, *SENSOR_FAULTS,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("name", "strength"),
    [
        *((name, 0.01) for name in (*LIBRARY, *OUTSIDE_THE_LIBRARY, *BETWEEN_THE_NAMES)),
        *((name, 0.0003) for name in ("cubic_stiffness", "freeplay", "coulomb_friction")),
    ],
)
def test_a_hidden_force_has_the_strength_asked_for(name, strength):
    truth = draw(name, strength, 11).truth
    effect = Effect(name, truth["parameters"])
    bench = Bench(truth["stiffness_per_mass"], truth["mu_0"], truth["mu_1"], (effect,))
    # Another grid than the one the search used.
    time = np.linspace(0.0, 8.0, 5000)
    motion = simulate(bench, Release(truth["from_m"], 0.0, truth["hand_s"]), time)
    ratio = np.sqrt(np.mean(motion.effects[0] ** 2) / np.mean(motion.acceleration**2))
    assert ratio == pytest.approx(strength, rel=0.01)  # two grids over the kinks of a friction


@pytest.mark.parametrize("name", sorted(SENSOR_FAULTS))
@pytest.mark.parametrize("strength", [0.003, 0.03])
def test_a_sensor_fault_has_the_strength_asked_for(name, strength):
    sample = draw(name, strength, 12, noise_displacement=0.0, noise_acceleration=0.0, bits=32)
    plain = draw(None, 0.0, 12, noise_displacement=0.0, noise_acceleration=0.0, bits=32)
    channel = sample.truth["parameters"]["channel"]
    other = "acceleration" if channel == "displacement" else "displacement"
    np.testing.assert_array_equal(getattr(sample, other), getattr(plain, other))
    after = np.arange(2240) / 256.0 >= sample.truth["released_at_s"]
    offset = plain.truth["offset_m" if channel == "displacement" else "offset_m_s2"]
    wrong = (getattr(sample, channel) - getattr(plain, channel))[after]
    signal = getattr(plain, channel)[after] - offset
    measure = np.std if name == "offset_drift" else lambda x: np.sqrt(np.mean(x**2))
    # Drop-outs come whole; the others are met to rounding.
    assert measure(wrong) / measure(signal) == pytest.approx(
        strength, rel=0.12 if name == "dropouts" else 0.01
    )


def test_what_is_recorded_is_the_truth_with_white_noise_on_it():
    for seed in range(2):
        sample = draw("cubic_stiffness", 0.01, seed)
        truth = sample.truth
        u, a = rebuilt(truth)
        du = (sample.displacement - u - truth["offset_m"]) / truth["noise_m"]
        da = (sample.acceleration - a - truth["offset_m_s2"]) / truth["noise_m_s2"]
        for residual in (du, da):
            # sd of an rms of 2240 values is 1.5 %; the converter adds up to 1 %: four of these.
            assert residual.std() == pytest.approx(1.0, abs=0.07)
            assert abs(residual.mean()) < 4.0 / np.sqrt(2240)


def test_the_seed_decides_the_bench_and_the_effect_does_not():
    a, b = draw("freeplay", 0.01, 5), draw(None, 0.0, 5)
    for key in ("stiffness_per_mass", "mu_0", "hand_s", "from_m", "noise_m", "displacement_late_s"):
        assert a.truth[key] == b.truth[key]
    again = draw("freeplay", 0.01, 5)
    np.testing.assert_array_equal(a.displacement, again.displacement)
    np.testing.assert_array_equal(a.acceleration, again.acceleration)


def test_draws_stay_inside_their_ranges_and_off_each_others_grid():
    truths = [draw(None, 0.0, seed).truth for seed in range(40)]
    ranges = {
        "stiffness_per_mass": (607.86, 620.14), "mu_0": (0.10, 0.15), "mu_1": (0.25, 0.30),
        "displacement_late_s": (-3e-3, 3e-3), "hand_s": (0.0, 0.012), "from_m": (-0.025, 0.025),
        "offset_m": (-2e-4, 2e-4), "offset_m_s2": (-0.05, 0.05), "noise_m": (3e-6, 8e-6),
        "noise_m_s2": (0.005, 0.015), "released_at_s": (0.75, 0.75 + 1 / 256),
    }  # fmt: skip
    for key, (low, high) in ranges.items():
        drawn = [truth[key] for truth in truths]
        assert low <= min(drawn) < max(drawn) <= high
        assert len({x for x in drawn if x}) == len([x for x in drawn if x])
    assert all(0.015 <= abs(truth["from_m"]) <= 0.025 for truth in truths)
    assert {truth["from_m"] > 0.0 for truth in truths} == {True, False}
    assert {truth["hand_s"] > 0.0 for truth in truths} == {True, False}


def test_two_effects_are_both_as_strong_as_asked_for():
    truth = draw("second_mass+quadratic_damping", (0.02, 0.005), 8).truth
    assert truth["strengths_reached"]["second_mass"] == pytest.approx(0.02, rel=2e-3)
    assert truth["strengths_reached"]["quadratic_damping"] == pytest.approx(0.005, rel=2e-3)
    assert truth["kind"] == "physics"
    assert draw("freeplay+mains_hum", 0.01, 8).truth["kind"] == "physics+sensor"
    assert draw("magnet", 0.01, 8).truth["kind"] == "outside"
    assert draw("power_law_damping", 0.01, 8).truth["kind"] == "between"


def test_a_gain_error_is_there_when_asked_for():
    plain = draw(None, 0.0, 3, noise_acceleration=0.0)
    more = draw(None, 0.0, 3, noise_acceleration=0.0, gain_error=0.01)
    offset = plain.truth["offset_m_s2"]
    ratio = np.std(more.acceleration - offset) / np.std(plain.acceleration - offset)
    assert ratio == pytest.approx(1.01, rel=1e-4)  # one step of the converter is 0.04 % of the rms


def test_what_cannot_be_hidden_is_named():
    with pytest.raises(ValueError, match="no effect is called 'gremlin'"):
        draw("gremlin", 0.01, 1)
    with pytest.raises(TypeError, match="a bench has no colour"):
        draw(None, 0.0, 1, colour="red")
    with pytest.raises(ValueError, match="2 effects need 2 strengths"):
        draw("freeplay+magnet", (0.1, 0.1, 0.1), 1)


def test_the_truth_is_json():
    for name in ("second_mass", "dropouts", None, "freeplay+clipping"):
        truth = draw(name, 0.01, 1).truth
        assert set(json.loads(json.dumps(truth, allow_nan=False))) == set(truth)


def test_another_programs_releases_are_reproduced_to_their_noise():
    """The two simulators share nothing but the table's formulas."""
    checked = 0
    for truth in json.loads((HIDDEN / "truth.json").read_text()):
        names = [name for name in truth["hidden"].split("+") if name != "none"]
        if any(name not in PARAMETERS for name in names):
            continue
        parameters = truth["parameters"] if len(names) > 1 else dict.fromkeys(names, truth["parameters"])
        for name, values in parameters.items():
            if name == "end_stop":
                values["side"] = 1.0  # Theirs stands on the positive side.
            if name == "hysteresis":
                values["z_start"] = 0.0  # Theirs has relaxed while held.
            if name == "magnet":
                values["q"] = -values["q"]  # Theirs pulls towards positive displacement.
        truth["parameters"] = parameters if len(names) > 1 else parameters.get((names or [""])[0], {})
        u, a = rebuilt(truth)
        seen = np.loadtxt(HIDDEN / truth["file"], delimiter=",", skiprows=1)
        for residual, noise in ((seen[:, 1] - u, truth["noise_m"]), (seen[:, 2] - a, truth["noise_m_s2"])):
            # sd of an rms of 2240 values is 1.5 %, the converter adds up to 1 %: four of these.
            assert residual.std() / noise == pytest.approx(1.0, abs=0.07), truth["file"]
        checked += 1
    assert checked > 1
