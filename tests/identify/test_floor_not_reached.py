"""Names off the floor: where the noise is not known, or small forces hide it, a right name and no wrong one."""

from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import lfilter
from specimens import Specimen, among

from identify.diagnosis.diagnose import diagnose
from identify.diagnosis.ladder import add_effect, first_step
from identify.effects.library import find_effect
from identify.errors import NotIdentifiable
from identify.free_decay import FreeDecay
from identify.judging.suspects import Candidate, is_predicted
from identify.preprocessing.prepared_decay import prepare
from mocks.generate import draw

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
SPRINGS = among("pendulum_stiffness", "cubic_stiffness", "settling_stiffness")
STATIONARY = among(
    "cubic_stiffness", "end_stop", "freeplay", "hysteresis", "quadratic_damping", "position_dependent_damping"
)


@pytest.mark.parametrize("name", ["pendulum_stiffness", "cubic_stiffness"])
def test_a_spring_leads_though_the_noise_is_unknown_and_small_forces_are_beside_it(name: str):
    """A swing from 1.2 rad, by a sine or by a cubic of less; a bearing's ripple of 0.05 %."""
    spring = np.sin if name == "pendulum_stiffness" else lambda u: u - u**3 / 8.0
    time = np.arange(2000) / 50.0
    run = solve_ivp(
        lambda t, y: [y[1], -38.0 * spring(y[0]) - 0.05 * y[1] - 0.02 * np.sin(40.0 * y[0])],
        (0.0, 40.0), [1.2, 0.0], t_eval=time, rtol=1e-9, atol=1e-11,
    )  # fmt: skip
    noisy = run.y[0] + 1e-3 * np.random.default_rng(1).standard_normal(len(time))
    found = diagnose(FreeDecay(50.0, noisy, unit="rad"), library=SPRINGS)
    assert not found.baseline.floor_is_sure
    assert found.suspects[0].effect.name == name
    # Gravity's strength is predicted by the spring; a cubic's is not, and a record alone need not vouch for it.
    assert found.named in (((name,),) if name == "pendulum_stiffness" else ((name,), ()))


@pytest.mark.parametrize(("gravity", "added", "predicted"), [(38.0, 0.0, True), (30.0, 8.0, False)])
def test_gravity_alone_has_the_strength_of_the_whole_linear_spring(
    gravity: float, added: float, predicted: bool
):
    """A pendulum, and one with a spring at its axis: u" + (gravity + added) u is its motion at small angles."""
    time = np.arange(600) / 50.0
    run = solve_ivp(
        lambda t, y: [y[1], -gravity * np.sin(y[0]) - added * y[0] - 0.05 * y[1]],
        (0.0, 12.0), [1.2, 0.0], t_eval=time, rtol=1e-9, atol=1e-11,
    )  # fmt: skip
    noisy = run.y[0] + 1e-3 * np.random.default_rng(1).standard_normal(len(time))
    ground = first_step((prepare(FreeDecay(50.0, noisy, unit="rad")),))
    found = add_effect(ground, find_effect("pendulum_stiffness")).fit
    candidate = Candidate(found.model.terms[-1], found, 0.0, plausible=True)
    assert is_predicted(candidate) == predicted
    cubic = add_effect(ground, find_effect("cubic_stiffness")).fit
    assert not is_predicted(Candidate(cubic.model.terms[-1], cubic, 0.0, plausible=True))


FOLLOWERS = among(
    "mains_hum",
    "harmonic_forcing",
    "second_mass",
    "pendulum_stiffness",
    "settling_stiffness",
    "cubic_stiffness",
)


@pytest.mark.parametrize("seed", [2, 4])
def test_what_follows_any_motion_for_a_while_keeps_no_name_from_a_pendulum(seed: int):
    """Eight cycles from 1.5 rad with drag, filmed: a free second mass, or a line, leaves less than the sine alone."""
    time = np.arange(217) / 15.0
    run = solve_ivp(
        lambda t, y: [y[1], -13.25 * np.sin(y[0]) - 0.1 * y[1] - 0.03 * y[1] * abs(y[1])],
        (0.0, time[-1]), [1.5, 0.0], t_eval=time, rtol=1e-9, atol=1e-11,
    )  # fmt: skip
    noise = np.random.default_rng(seed).standard_normal((2, len(time)))
    tracked = run.y[0] + 2e-3 * noise[0] + 3e-3 * lfilter([1.0], [1.0, -0.8], noise[1])
    found = diagnose(FreeDecay(15.0, tracked, unit="rad"), library=FOLLOWERS)
    assert found.named == ("pendulum_stiffness",)
    left = {one.effect.name: one.fit.chi_square for one in found.suspects}
    assert min(left["second_mass"], left["harmonic_forcing"]) < left["pendulum_stiffness"]


@pytest.mark.parametrize(("ratio", "force", "seconds", "seed"), [(1.08, 0.09, 25.0, 0), (0.9, 0.06, 20.8, 1)])
def test_a_drive_that_begins_beats_and_is_no_second_mass(
    ratio: float, force: float, seconds: float, seed: int
):
    """Driven off resonance from the first reading: the free motion beats with the forced one until it has died away."""
    w, time = 2.0 * np.pi * 1.2, np.arange(int(25.0 * seconds)) / 25.0
    run = solve_ivp(
        lambda t, y: [y[1], w**2 * (force * np.cos(ratio * w * t + 1.0) - y[0]) - 0.02 * w * y[1]],
        (0.0, time[-1]), [1.0, 0.0], t_eval=time, rtol=1e-8, atol=1e-10,
    )  # fmt: skip
    noise = np.random.default_rng(seed).standard_normal((2, len(time)))
    reading = run.y[0] + 4e-3 * noise[0] + 5e-3 * lfilter([1.0], [1.0, -0.85], noise[1])
    found = diagnose(FreeDecay(25.0, reading), library=FOLLOWERS)
    assert "second_mass" not in found.named
    left = {one.effect.name: one.fit.chi_square for one in found.suspects}
    assert max(left["second_mass"], left["harmonic_forcing"]) < 0.5 * found.baseline.fit.chi_square


def test_a_law_that_two_others_beat_has_no_name_where_these_have_none():
    """Nine cycles of a pendulum with drag, in steps of 6 mrad: a loop follows both, and a walk of the damper the drag."""
    time = np.arange(244) / 15.0
    run = solve_ivp(
        lambda t, y: [y[1], -12.1 * np.sin(y[0]) - 0.0126 * y[1] - 0.108 * y[1] * abs(y[1])],
        (0.0, time[-1]), [0.97, 0.0], t_eval=time, rtol=1e-9, atol=1e-11,
    )  # fmt: skip
    noisy = run.y[0] + 2.1e-3 * np.random.default_rng(67).standard_normal(len(time))
    library = among(*(one.name for one in FOLLOWERS), "hysteresis", "dahl_friction", "quadratic_damping")
    found = diagnose(FreeDecay(15.0, np.round(noisy / 6e-3) * 6e-3, unit="rad"), library=library)
    assert set(found.named) <= {"pendulum_stiffness", "quadratic_damping"}
    assert next(one for one in found.suspects if one.effect.name == "hysteresis").plausible


def test_one_release_of_a_disc_whose_frequency_may_drift_or_depend_on_the_amplitude_has_no_name():
    """A card disc on a spring: drag is there, and besides a frequency that one release does not part from a drift."""
    position = np.loadtxt(EXAMPLES / "spring_disc.csv", delimiter=";", skiprows=1)[::4, 1]
    rivals = among("quadratic_damping", "cubic_stiffness", "settling_stiffness", "time_varying_stiffness")
    found = diagnose(FreeDecay(25.0, position), library=rivals)
    assert (found.verdict, found.named) == ("unconfirmed", ())


def test_a_misfit_that_is_next_to_nothing_is_not_something_missing():
    """An exact viscous decay, written with six digits: far above the noise of its last decade, 1e-4 % of the motion."""
    times = np.arange(300) / 10.0
    pole = complex(-0.25, np.sqrt(4.0 - 0.25**2))
    u = np.array([float(f"{x:.6g}") for x in np.exp(pole * times).real])
    v = np.array([float(f"{x:.6g}") for x in (pole * np.exp(pole * times)).real])
    found = diagnose(FreeDecay(10.0, displacement=u, velocity=v), library=STATIONARY)
    assert not found.baseline.adequate(found.baseline.fit)
    assert (found.verdict, found.named) == ("nothing_missing", ())
    assert "too little to name an effect" in found.explanation


def test_readings_that_are_lost_are_told_where_the_misfit_is_next_to_nothing():
    time = np.arange(400) / 20.0
    u = np.exp(-0.1 * time) * np.cos(2.0 * np.pi * time)
    u += 1e-6 * np.exp(-0.2 * time) * np.random.default_rng(3).standard_normal(400)
    for place in (40, 41, 42, 90, 91, 150, 151, 152, 153, 200, 201, 202, 250, 251, 300, 301, 302, 303):
        u[place] = u[place - 1]
    names = ("mains_hum", "cubic_stiffness", "quadratic_damping", "dropouts")
    found = diagnose(FreeDecay(20.0, displacement=u), library=among(*names))
    assert not found.baseline.adequate(found.baseline.fit)
    assert (found.verdict, found.named) == ("sensor_fault", ("dropouts",))


def test_another_mode_in_the_reading_is_no_force_on_the_first():
    """A beam's second mode, 6.27 times as fast, stands in the accelerometer beside the first: nothing couples the two."""
    random, time, w = np.random.default_rng(1), np.arange(4000) / 500.0, 2.0 * np.pi * 8.0
    first = 0.01 * w**2 * np.exp(-0.3 * time) * np.cos(w * time)
    second = 0.15 * 0.01 * w**2 * np.exp(-2.0 * time) * np.cos(6.27 * w * time + 1.0)
    found = diagnose(
        FreeDecay(500.0, acceleration=first + second + 0.02 * random.standard_normal(len(time))),
        library=among("second_mass", "harmonic_forcing", "cubic_stiffness"),
    )
    assert found.named == ()
    assert "may be zero" in found.explanation
    assert [mode.frequency for mode in found.modes] == [pytest.approx(50.2, rel=0.02)]


def test_of_a_name_whose_strength_is_unknown_no_numbers_are_stated():
    """A swing so near the bounce of a spring that the amplitude beats: two masses or two modes, it reads alike."""
    random, time = np.random.default_rng(1), np.arange(1800) / 60.0
    bounce = 0.05 * np.exp(-0.03 * time) * np.cos(2.0 * np.pi * 1.2 * time)
    swing = 0.009 * np.exp(-0.02 * time) * np.cos(2.0 * np.pi * 1.02 * time + 1.0)
    found = diagnose(
        FreeDecay(60.0, displacement=bounce + swing + 5e-5 * random.standard_normal(len(time))),
        library=among("second_mass", "harmonic_forcing", "cubic_stiffness"),
    )
    assert found.named == ("second_mass",)
    assert "second mass (this record does not determine its strength)" in found.explanation
    known = {suspect.effect.name: suspect.strength_known for suspect in found.suspects}
    assert not known["second_mass"]
    assert known["cubic_stiffness"]  # of a strength alone the error says all


def test_noise_that_swings_by_itself_is_no_decay_and_what_to_look_at_is_said():
    """White noise through a resonance damped to a tenth in eleven readings; a floor that is guessed as large excuses all."""
    few = among("cubic_stiffness", "quadratic_damping", "harmonic_forcing")
    found = []
    for seed in (5, 6, 17, 19):
        noise = np.random.default_rng(seed).standard_normal(1500)
        swinging = lfilter([1.0], [1.0, -np.exp(-0.2 + 0.3j)], noise).real
        with suppress(NotIdentifiable):
            found.append(diagnose(FreeDecay(50.0, swinging), library=few))
    assert {one.named for one in found} == {()}
    drowned = [one for one in found if one.verdict == "not_enough_data"]
    assert any(
        "is this the right column, and is the mass swinging freely?" in one.explanation for one in drowned
    )


def test_fewer_than_five_cycles_tell_no_effects_apart():
    time = np.arange(230) / 50.0  # 4.6 cycles, where 5 are asked for
    u = np.exp(-0.05 * time) * np.cos(2.0 * np.pi * time)
    found = diagnose(FreeDecay(50.0, u + 1e-3 * np.random.default_rng(1).standard_normal(len(time))))
    assert (found.verdict, found.named) == ("not_enough_data", ())
    assert found.explanation.startswith("Fewer than five cycles")


@pytest.mark.parametrize(
    ("hidden", "strength", "seed", "rest"),
    [("wandering_damping", 0.001, 8063, 0), ("amplitude_switched_damping", 0.002, 9068, 256)],
)
def test_a_law_that_reaches_a_guessed_floor_must_also_beat_a_random_walk_and_a_smooth_law(
    hidden: str, strength: float, seed: int, rest: int
):
    simulated = draw(hidden, strength, seed)
    first = 256 - rest
    acceleration = None if rest else simulated.acceleration[first:]
    laws = among(
        "fading_damping", "fading_friction", "stribeck_friction", "quadratic_damping", "cubic_stiffness"
    )
    found = diagnose(FreeDecay(simulated.rate, simulated.displacement[first:], acceleration), library=laws)
    assert not found.baseline.floor_is_sure
    assert found.suspects[0].claimed
    assert found.baseline.adequate(found.suspects[0].fit)
    assert found.named == ()


def test_shaking_beside_a_force_is_no_hum_of_a_sensor():
    """Both channels show it, at the amplitude that its acceleration has at 30 Hz; the rest is not there to compare."""
    hidden = {"harmonic_forcing": {"f": 30.0}}
    sample = draw("cubic_stiffness+harmonic_forcing", (0.03, 0.01), 901, parameters=hidden)
    found = diagnose(
        FreeDecay(sample.rate, sample.displacement[300:1200], sample.acceleration[300:1200]),
        library=among("cubic_stiffness", "harmonic_forcing", "mains_hum", "hysteresis"),
    )
    assert not found.baseline.floor_is_sure
    assert found.named == ("cubic_stiffness", "harmonic_forcing")


PAIRS = [
    ("end_stop", "position_dependent_damping", 7),
    ("cubic_stiffness", "quadratic_damping", 9),
]


@pytest.mark.parametrize(("first", "second", "seed"), PAIRS)
def test_two_forces_in_one_channel_are_named_with_their_values(first: str, second: str, seed: int):
    """One of them alone leaves many times the noise, and has a wrong value or a wrong name."""
    sample = draw(f"{first}+{second}", (0.08, 0.04), seed, seconds=10.0)
    found = diagnose(FreeDecay(sample.rate, displacement=sample.displacement), library=STATIONARY)
    assert not found.baseline.floor_is_sure
    assert set(found.named) == {first, second}
    assert found.baseline.adequate(found.final)
    assert min(one.fit.reduced for one in found.suspects if one.effect.name in found.named) > 5.0
    for one in found.named_suspects:
        strength = one.effect.strength.name
        truth, estimate = sample.truth["parameters"][one.effect.name][strength], one.parameters[strength]
        assert abs(estimate.value - truth) < 5.0 * estimate.std


def test_two_forces_in_one_channel_of_two_releases_are_named_together():
    specimen = Specimen("cubic_stiffness+quadratic_damping", 0.03, 5)
    draws = [
        draw(specimen.hidden, 0.03, 500 + i, amplitude=a, **specimen.made_of)
        for i, a in enumerate((0.02, -0.012))
    ]
    found = diagnose(
        tuple(FreeDecay(one.rate, displacement=one.displacement) for one in draws), library=STATIONARY
    )
    assert not found.baseline.floor_is_sure
    assert set(found.named) == {"cubic_stiffness", "quadratic_damping"}


def test_a_law_between_the_names_in_one_channel_has_its_exponent():
    sample = draw("power_law_damping", 0.05, 11, seconds=10.0)
    laws = among("power_law_damping", "cubic_damping", "fading_damping")
    found = diagnose(FreeDecay(sample.rate, displacement=sample.displacement), library=(*STATIONARY, *laws))
    assert found.named == ("power_law_damping",)


def test_gravity_and_a_damper_are_named_before_one_law_with_two_constants():
    """Integrated here: u'' + g sin u + c v + c3 v^3, an angle; hysteresis reaches the floor, too."""
    time = np.arange(512) / 50.0
    motion = solve_ivp(
        lambda t, y: [y[1], -34.1 * np.sin(y[0]) - 0.05 * y[1] - 0.02 * y[1] ** 3],
        (0.0, time[-1]),
        [0.7, 0.0],
        t_eval=time,
        rtol=1e-9,
        atol=1e-10,
    )
    noise = np.random.default_rng(1).normal(0.0, 1.5e-3, len(time))
    laws = among("pendulum_stiffness", "cubic_damping", "fading_damping")
    found = diagnose(FreeDecay(50.0, motion.y[0] + noise, unit="rad"), library=(*STATIONARY, *laws))
    assert found.named == ("pendulum_stiffness", "cubic_damping")


@pytest.mark.parametrize(("bends", "named"), [(1.0, True), (2.0, False)])
def test_gravity_is_named_by_few_cycles_though_a_tracker_errs_and_twice_as_much_is_no_gravity(
    bends: float, named: bool
):
    """A camera of 12 frames a second at a string pendulum: eight cycles of 1.4 rad, its middle drifts by a hundredth."""
    time = np.arange(230) / 12.0
    motion = solve_ivp(
        lambda t, y: [y[1], -9.2 * (y[0] + bends * (np.sin(y[0]) - y[0])) - 0.04 * y[1]],
        (0.0, time[-1]), [1.4 / bends**0.5, 0.0], t_eval=time, rtol=1e-9, atol=1e-10,
    )  # fmt: skip
    random = np.random.default_rng(7)
    drift = 0.012 * np.cos(np.pi * time / time[-1]) + lfilter(
        [0.006], [1.0, -0.8], random.standard_normal(len(time))
    )
    erring = motion.y[0] + drift + 5e-3 * random.standard_normal(len(time))
    found = diagnose(FreeDecay(12.0, erring, unit="rad"), library=(*SPRINGS, *among("hysteresis")))
    assert not found.baseline.adequate(found.suspects[0].fit)
    assert found.named == (("pendulum_stiffness",) if named else ())
