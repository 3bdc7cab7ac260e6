"""The model that was identified is judged on its own record, before anybody quotes a value of it."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from daq.manifest import Manifest
from daq.quality import Grade, Verdict
from daq.reading_flags import Flag
from daq.sensor_faults import FlaggedRun
from daq.session_info import State
from identify.effects.library import find_effect
from identify.estimate import Estimate
from identify.formatting import three_figures
from identify.free_decay import FreeDecay
from identify.identified import Identified
from identify.model.model import base_model, model_of_orders
from identify.preprocessing.aligned_decay import locate_and_align
from identify.preprocessing.prepared_decay import prepare
from identify.residual import residual_words
from identify.restoring_force.restoring_force import identify_restoring_force
from identify.wavelet.wavelet import identify_wavelet
from mocks.generate import draw
from station.cli import run
from station.story.adequacy import (
    adequacy,
    farthest,
    judgement,
    needed_orders,
    recording_doubt,
    scale_doubt,
)
from station.story.engineering_values import UNKNOWN, Weighing, engineering_values

MASS = 21.36


def found(order, k=600.0, mu_0=0.1, cubic=None):
    by_order = {1: Estimate(k, 0.01, "1/s^2")} | ({} if cubic is None else {3: cubic})
    damping = tuple(Estimate(mu_0, 0.001, "m/s^2") for _ in range(order + 1))
    return Identified(
        stiffness_by_order=by_order, stiffness_per_mass=by_order[1], damping=damping, order=order, reason="",
        mse_percent_by_order=(),
    )  # fmt: skip


@pytest.fixture(scope="module")
def releases():
    """A release of the plain bench, one with friction that rises at low speed; what the methods find, and the truth."""
    made = {}
    for name, effect, strength in (("plain", None, 0.0), ("hidden", "stribeck_friction", 0.02)):
        sample = draw(effect, strength, 3)
        decay = FreeDecay(sample.rate, sample.displacement, sample.acceleration)
        methods = [identify_wavelet(decay), identify_restoring_force(decay)]
        made[name] = prepare(decay), methods, sample.truth
    return made


def identified_model(*methods):
    return model_of_orders(*needed_orders(methods))


def test_the_model_has_the_orders_that_were_found():
    assert identified_model(found(1)).names == base_model().names
    bent = found(1, cubic=Estimate(5e5, 1e3, "1/(s^2 m^2)"))
    assert "cubic_stiffness" in identified_model(bent, found(2)).names
    assert identified_model(bent, found(2)).names[-1] == "quadratic_damping"
    straight = found(1, cubic=Estimate(5e2, 1e3, "1/(s^2 m^2)"))
    assert identified_model(straight).names == base_model().names
    assert model_of_orders(0).names == base_model().names[:2]
    assert model_of_orders(5, (1, 4)).names == ("linear_stiffness", "coulomb_friction", "viscous_damping",
                                               "quadratic_damping", "cubic_damping")  # fmt: skip


def test_methods_that_disagree_are_named_with_their_distance():
    one, other = found(1).parameters, found(1, mu_0=0.11).parameters
    name, sigmas = farthest({"wavelet": one, "restoring force": one, "simulation": other})
    assert sigmas == pytest.approx(0.01 / math.hypot(0.001, 0.001))
    assert name.startswith(("dry friction", "viscous"))
    assert name.endswith("and by simulation")
    bent = [found(1, cubic=Estimate(k_3, 1.0, "1/(s^2 m^2)")).parameters for k_3 in (-6.0, -70.0)]
    assert farthest({"wavelet": bent[0], "simulation": bent[1]})[0].startswith(
        "stiffness of order 3 by wavelet"
    )


def test_no_value_of_a_recording_at_fault_may_be_quoted(releases):
    run = FlaggedRun(channel="x", flag=Flag.SPIKE, first=3, count=1)
    verdicts = {grade: Verdict(grade=grade, reasons=("x is stuck",)) for grade in Grade}
    sealed = Manifest(state=State.SEALED, files={}, verdict=verdicts[Grade.USABLE])
    assert recording_doubt(sealed) == ""
    assert (
        recording_doubt(
            sealed.model_copy(update={"flags": (run.model_copy(update={"flag": Flag.SATURATED}),)})
        )
        == ""
    )
    assert "x: spike" in recording_doubt(sealed.model_copy(update={"flags": (run,)}))
    doubt = recording_doubt(sealed.model_copy(update={"verdict": verdicts[Grade.REJECT]}))
    assert doubt == "the recording is REJECT (x is stuck)"
    judged = adequacy(*releases["plain"][:2], doubt)
    assert judged.adequate
    assert not judged.quotable
    assert judgement(judged).endswith("but the recording is REJECT (x is stuck): do not quote its values")


def test_a_plain_bench_may_be_quoted_and_its_values_are_the_truth(releases):
    *found_by_methods, truth = releases["plain"]
    judged = adequacy(*found_by_methods)
    assert judged.quotable
    assert judgement(judged).endswith("may be quoted")
    values = {one.name: one for one in engineering_values(judged.fit, Weighing(MASS))}
    omega = math.sqrt(truth["stiffness_per_mass"])
    zeta = truth["mu_1"] / (2 * omega)
    for name, true, unit in (
        ("stiffness K", MASS * truth["stiffness_per_mass"], "N/m"),
        ("friction force", MASS * truth["mu_0"], "N"),
        ("viscous damping μ₁", MASS * truth["mu_1"], "N s/m"),
        ("natural frequency", omega / (2 * math.pi), "Hz"),
        ("damping ratio (viscous part)", zeta, "1"),
        ("logarithmic decrement (viscous part)", 2 * math.pi * zeta / math.sqrt(1 - zeta**2), "1"),
    ):
        value = values[name].value
        assert value.unit == unit
        assert abs(value.value - true) < 5.0 * value.std  # one draw in a million lies beyond
    assert values["friction force"].per_mass.value == pytest.approx(
        values["friction force"].value.value / MASS
    )


def test_a_bench_with_a_hidden_force_may_not_be_quoted(releases):
    judged = adequacy(releases["hidden"][0], [found(1)])
    assert judged.error.chi_square > 10.0
    assert not judged.quotable
    assert judgement(judged).endswith("do not quote its values")


def test_an_adequate_model_is_not_quoted_where_the_methods_contradict_each_other(releases):
    prepared, (wavelet, force), _ = releases["plain"]
    off = replace(force, damping=(replace(force.damping[0], value=0.2), force.damping[1]))
    judged = adequacy(prepared, [wavelet, off])
    assert judged.adequate
    assert not judged.quotable
    assert "but dry friction mu_0 by restoring force and by simulation are" in judgement(judged)


def test_one_method_is_not_quoted_where_the_simulation_contradicts_it(releases):
    prepared, (wavelet, _), _ = releases["plain"]
    assert adequacy(prepared, [wavelet]).quotable
    k = replace(wavelet.stiffness, value=1.5 * wavelet.stiffness.value)
    assert not adequacy(
        prepared, [replace(wavelet, stiffness_by_order={1: k}, stiffness_per_mass=k)]
    ).quotable


def test_a_linear_spring_that_alone_would_not_oscillate_has_a_damping_ratio_and_no_decrement():
    values = {"linear_stiffness.k": 0.05, "coulomb_friction.mu_0": 0.02, "viscous_damping.mu_1": 0.8}
    units = {"linear_stiffness.k": "1/s^2", "coulomb_friction.mu_0": "m/s^2", "viscous_damping.mu_1": "1/s"}
    estimates = {name: Estimate(value, 1e-3, units[name]) for name, value in values.items()}
    fit = SimpleNamespace(
        model=base_model(),
        values=estimates,
        of=lambda term, _: {term.strength.parameter: estimates[str(term.strength)]},
    )
    quoted = {one.name: one.value.value for one in engineering_values(fit, UNKNOWN)}
    assert quoted["damping ratio (viscous part)"] == pytest.approx(0.8 / (2 * math.sqrt(0.05)))
    assert "logarithmic decrement (viscous part)" not in quoted


@pytest.mark.parametrize(("share", "quoted"), [(0.0, True), (0.004, True), (0.02, False), (0.1, False)])
def test_values_are_quoted_only_where_the_sampling_rate_is_known_to_half_a_percent(releases, share, quoted):
    prepared = releases["plain"][0]
    timed = replace(prepared, window=replace(prepared.window, rate_std=share * prepared.window.rate))
    judged = adequacy(timed, releases["plain"][1])
    assert judged.quotable is quoted
    assert quoted or f"the sampling rate may be off by {100 * share:g} %: do not quote" in judgement(judged)
    stiffness = {one.name: one.value for one in engineering_values(judged.fit, Weighing(MASS))}["stiffness K"]
    assert stiffness.std >= 2 * share * stiffness.value  # the square of the rate


def test_where_any_model_would_pass_no_value_is_quoted():
    """A slow camera whose reading wavers: of its noise nothing is known, and so 5 % of the motion may all be noise."""
    time, random = np.arange(120) / 12.0, np.random.default_rng(0)
    waver = np.convolve(random.standard_normal(124), np.full(5, 0.2), "valid")
    angle = 0.8 * np.exp(-0.05 * time) * np.cos(2.0 * np.pi * time) + 0.04 * waver
    seen = adequacy(prepare(FreeDecay(12.0, angle, unit="rad")), [found(1, k=39.5)])
    assert seen.adequate
    assert not seen.quotable
    assert "only a guess, and any model would pass: do not quote its values" in judgement(seen)


def test_where_the_guessed_noise_is_far_above_all_that_is_left_no_value_is_quoted():
    """Four readings a cycle look like noise to the estimate: a spring that loses 6 % passes beside that."""
    time, random = np.arange(112) / 4.5, np.random.default_rng(0)
    phase = 2.0 * np.pi * 1.07 * (time - 0.0006 * time**2)
    reading = np.exp(-0.06 * time) * np.cos(phase) + 0.002 * random.standard_normal(112)
    seen = adequacy(prepare(FreeDecay(4.5, reading)), [found(1, k=45.2)])
    assert seen.adequate
    assert seen.error.motion_percent > 0.7  # of a reading with 0.2 % of noise
    assert "only a guess, and any model would pass: do not quote its values" in judgement(seen)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_dry_friction_below_zero_is_not_quoted(seed):
    """Drag alone, beside noise that hides its order: friction below zero and more viscous damping pass for it."""
    sample = draw("quadratic_damping", 0.005 * seed, seed, mu_0=0.0, mu_1=0.1, noise_displacement=1e-3)
    located = locate_and_align(FreeDecay(sample.rate, sample.displacement))
    seen = adequacy(prepare(located), [identify_wavelet(located.decay, 1)])
    assert seen.adequate
    assert not seen.quotable
    assert "dry friction is below zero" in judgement(seen)


def test_gains_that_differ_leave_the_forces_uncertain():
    assert scale_doubt(Estimate(1.0003, 0.0001, "1")) == ""
    assert scale_doubt(Estimate(1.01, 0.01, "1")) == ""
    assert "differ by 1 %" in scale_doubt(Estimate(1.01, 0.0001, "1"))


def test_a_large_ratio_is_a_power_of_ten():
    assert [three_figures(ratio) for ratio in (0.9876, 22.91, 229.1, 286998817.0)] == [
        "0.988",
        "22.9",
        "229",
        "2.87 × 10⁸",
    ]


def test_the_error_of_the_mass_joins_that_of_the_value():
    whole = Weighing(20.0, 0.5).strength(Estimate(0.1, 0.001, "m/s^2"))
    assert (whole.value, whole.unit) == (2.0, "N")
    assert whole.std == pytest.approx(math.hypot(0.02, 0.05))
    assert Weighing(2.0, None, "rad").strength(Estimate(0.1, 0.001, "rad/s^2")).unit == "N m"
    assert Weighing(2.0).strength(Estimate(0.1, 0.001, "V/s^2")).unit == "kg V/s^2"
    share = Estimate(0.1, 0.001, "1")
    assert Weighing(2.0).strength(share) is share


@pytest.mark.slow
def test_identify_says_first_whether_to_quote_and_where_to_look_next(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    sample = draw("stribeck_friction", 0.02, 3)
    time = np.arange(len(sample.displacement)) / sample.rate
    table = np.column_stack([time, sample.displacement, sample.acceleration])
    np.savetxt("a b.csv", table, delimiter=",", header="time_s,displacement_m,acceleration_m_s2", comments="")
    assert run(["identify", "a b.csv", "--mass", str(MASS)]) == 0
    text = capsys.readouterr().out
    assert text.index("do not quote") < text.index("stiffness K")
    assert " N s/m " in text
    assert "per unit mass" not in text
    assert text.rstrip().endswith("next: station compare sessions/a_b")
    assert all(len(line) <= 80 for line in text.splitlines())


def test_what_is_relative_to_another_effect_has_no_mass_in_it():
    weighing = Weighing(2.0)
    given = Estimate(0.03, 0.001, "1/s")
    assert weighing.weighed("time_varying_stiffness", {"rate": given}) == {"rate": given}
    whole = weighing.weighed("viscous_damping", {"mu_1": given})["mu_1"]
    assert (whole.value, whole.unit) == (0.06, "N s/m")
    effects = [find_effect(name) for name in ("linear_stiffness", "second_mass", "channel_lag")]
    assert weighing.terms(effects)[:2] == ["m u''", "k u"]
    assert weighing.terms(effects)[2] == (
        "m (ratio (w2^2 (u - y) + 2 zeta w2 (v - y'))),  y'' = w2^2 (u - y) + 2 zeta w2 (v - y')"
    )
    assert UNKNOWN.terms(effects)[0] == "u''"


def test_a_run_that_diverges_and_a_small_residual_that_repeats_are_said_so():
    assert residual_words(None, math.inf) == "the whole motion, which it does not follow at all"
    assert residual_words(2.5, 0.9, 0.03).endswith(", but it repeats with the motion, as noise does not")
    assert (
        residual_words(2.5, 1.9, 0.03)
        == residual_words(2.5, 1.9)
        == "2.50 % of the motion, 1.38 times the noise"
    )


@pytest.mark.parametrize(("size", "adequate"), [(3e-5, True), (6e-3, False)])
def test_a_residual_far_below_what_names_an_effect_is_adequate_above_a_guessed_floor(size, adequate):
    """A decay with a little of its third harmonic in hardly any noise: of the first `diagnose` misses nothing."""
    time = np.arange(1200) / 100.0
    motion = np.exp(-0.25 * time) * np.cos(10.0 * time) + size * np.exp(-0.75 * time) * np.cos(30.0 * time)
    decay = FreeDecay(100.0, motion + 1e-8 * np.random.default_rng(1).standard_normal(1200))
    found = adequacy(prepare(decay), [identify_wavelet(decay), identify_restoring_force(decay)])
    assert found.error.chi_square > 100.0
    assert found.adequate is found.negligible is adequate
    assert ("too little to name an effect by" in judgement(found)) is adequate
