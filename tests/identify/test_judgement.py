"""The judgement: a weak fault needs a sure floor, and what is sure but small is named or not as was asked."""

from dataclasses import replace

import numpy as np
import pytest
from releases import drawn
from specimens import among

from identify.curves.confirm import Curves
from identify.diagnosis.diagnose import diagnose
from identify.effects.library import LIBRARY, find_effect
from identify.fitting.baseline import fit_baseline
from identify.fitting.corrected_faults import CorrectedFault
from identify.fitting.initial_values import scales_of
from identify.fitting.model_error import motion_percent
from identify.free_decay import FreeDecay
from identify.judging.judgement import judge
from identify.model.model import Term, base_model
from mocks.generate import draw

FORCES = among("cubic_stiffness", "quadratic_damping", "stribeck_friction")


def test_a_weak_fault_of_a_sensor_is_claimed_only_where_the_floor_is_sure():
    prepared, _ = drawn(None, 0.0, 5001)
    sure = fit_baseline((prepared,), base_model())
    noise = {name: replace(one, source="guess") for name, one in prepared.noise.items()}
    guessed = replace(sure, decays=(replace(prepared, noise=noise),))
    assert sure.floor_is_sure
    assert not guessed.floor_is_sure
    weak = CorrectedFault(Term(find_effect("channel_gain")), 14.0, 0, {})  # by chance once in 150
    strong = replace(weak, drop=40.0)
    curves = Curves((), base_model(), {}, (), scales_of(prepared, {}))
    for baseline, fault, verdict in (
        (sure, weak, "sensor_fault"),
        (guessed, weak, "nothing_missing"),
        (guessed, strong, "sensor_fault"),
    ):
        assert judge(baseline, (), (fault,), LIBRARY, curves).verdict == verdict


def test_a_force_that_is_sure_but_small_is_named_with_what_it_removes_or_not_where_more_is_asked():
    prepared, _ = drawn("cubic_stiffness", 0.001, 44)
    found = diagnose((prepared,), library=FORCES)
    assert found.named == ("cubic_stiffness",)
    before, after = motion_percent(found.baseline.fit), motion_percent(found.final)
    removed = (before**2 - after**2) ** 0.5
    assert removed < 0.5
    assert f"from {before:.3g} to {after:.3g} % of the motion" in found.explanation
    assert f"What is named removes only {removed:.3g} % of the motion" in found.explanation
    assert diagnose((prepared,), library=FORCES, worth=0.9 * removed).named == ("cubic_stiffness",)
    small = diagnose((prepared,), library=FORCES, worth=1.1 * removed)
    assert (small.verdict, small.named) == ("nothing_missing", ())
    assert not any(suspect.claimed for suspect in small.suspects)
    assert small.explanation.startswith(
        f"Cubic stiffness is significant, but it removes only {removed:.3g} % of the motion"
    )
    ladder = small.refine()
    assert len(ladder.steps) == 1
    assert ladder.stopped_because == "the residual is too small a part of the motion to name an effect"


def test_the_verdict_follows_from_what_was_weighed():
    prepared, _ = drawn("cubic_stiffness", 0.01, 47)
    found = diagnose((prepared,), library=FORCES)
    (one,) = found.decided
    assert (found.named, one.verdict, one.names[0]) == (("cubic_stiffness",), "named", "cubic_stiffness")
    assert max(one.nats, key=lambda name: one.nats[name]) == "cubic_stiffness"
    assert one.nats["cubic_stiffness"] > one.unnamed
    prepared, _ = drawn("magnet", 0.03, 9)  # outside the library
    found = diagnose((prepared,), library=FORCES)
    assert (found.verdict, found.named) == ("unknown_effect", ())
    (one,) = found.decided
    assert one.verdict != "named"


@pytest.mark.slow
def test_a_law_of_a_family_is_weighed_in_the_same_unit_as_its_rivals():
    prepared, _ = drawn("lugre_friction", 0.02, 601)
    found = diagnose((prepared,))
    assert found.named == ("lugre_friction",)
    (one,) = found.decided
    behind = next(s for s in found.suspects if s.effect.name == "dahl_friction")
    weighed = one.nats["lugre_friction"] - one.nats["dahl_friction"]
    assert weighed == pytest.approx(found.suspects[0].evidence - behind.evidence)
    assert weighed == pytest.approx(0.5 * (behind.fit.chi_square - found.final.chi_square), rel=0.3)


def test_a_line_of_one_sensor_is_named_beside_a_spring_that_wanders():
    sample = draw("wandering_stiffness", 3e-4, 702)
    time = np.arange(len(sample.displacement)) / sample.rate
    hum = 0.002 * np.abs(sample.displacement).max() * np.sin(2.0 * np.pi * 50.0 * time)
    rivals = among("mains_hum", "harmonic_forcing", "time_varying_stiffness", "cubic_stiffness")
    found = diagnose(FreeDecay(sample.rate, sample.displacement + hum, sample.acceleration), library=rivals)
    assert (found.verdict, found.named) == ("sensor_fault", ("mains_hum",))
    assert found.walk is not None
    frequency = found.suspects[0].parameters["f"]
    assert frequency.value == pytest.approx(50.0, abs=5.0 * frequency.std)


def test_one_effect_that_is_left_of_a_pair_counts_with_the_values_it_has_there():
    """Two modes 3 % apart for half a beat: alone the second mass is implausible, and from the pair it is not."""
    time, random = np.arange(900) / 30.0, np.random.default_rng(1)
    u = 0.05 * np.exp(-0.008 * time) * (np.cos(4.054 * time + 0.5) + np.cos(3.938 * time - 0.5))
    found = diagnose(
        FreeDecay(30.0, displacement=u + 1e-4 * random.standard_normal(len(time))),
        library=among("second_mass", "maxwell_element", "mains_hum"),
    )
    assert found.named == ("second_mass",)
    assert found.suspects[0].plausible
