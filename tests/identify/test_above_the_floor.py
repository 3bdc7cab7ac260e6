"""A name above a known floor: sensors noisier in motion than at rest hide no force, and a walk is given no name."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from identify.diagnosis.diagnose import Diagnosis, diagnose
from identify.effects.library import find_effect
from identify.fitting.baseline import fit_baseline
from identify.fitting.model_error import may_hide_anything, motion_percent
from identify.free_decay import FreeDecay
from identify.judging.floor_not_reached import agree
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import prepare
from mocks.generate import draw
from mocks.imperfections import IMPERFECTIONS

SUSPECTS = (
    "freeplay",
    "cubic_stiffness",
    "time_varying_stiffness",
    "settling_stiffness",
    "end_stop",
    "second_mass",
)


def found(
    hidden: str, strength: float, seed: int, suspects: tuple[str, ...] = SUSPECTS, **more: Any
) -> Diagnosis:
    sample = draw(hidden, strength, seed, **more)
    decay = prepare(FreeDecay(sample.rate, sample.displacement, sample.acceleration), gain_uncertainty=2e-4)
    return diagnose(decay, library=tuple(find_effect(name) for name in suspects))


@pytest.mark.parametrize(("hidden", "seed"), [("freeplay", 60611), ("cubic_stiffness", 60612)])
def test_under_every_imperfection_at_once_a_force_is_named_and_what_it_leaves_is_said(
    hidden: str, seed: int
) -> None:
    """1/f noise, hum, drift, a bent sensor and twelve bits leave 1.7 times the power of the rest: none of it is a law's."""
    diagnosed = found(hidden, 0.03, seed, imperfections=IMPERFECTIONS, bits=12)
    assert diagnosed.baseline.floor_is_sure
    assert not diagnosed.baseline.adequate(diagnosed.final)
    assert diagnosed.named == (hidden,)
    assert (
        "times the noise, but neither a random walk nor a smooth law explains more of it"
        in diagnosed.explanation
    )


@pytest.mark.parametrize(
    ("hidden", "strength", "seed"),
    [
        ("adhesion", 0.003, 771007),
        ("wandering_stiffness", 0.01, 771021),
        ("wandering_stiffness", 0.0003, 93000),  # beside which the end stop reaches the floor
    ],
)
def test_what_a_walk_explains_as_well_gets_no_name(hidden: str, strength: float, seed: int) -> None:
    """Free play takes most of what adhesion does, and an end stop of what a walk does; a walk explains the rest."""
    diagnosed = found(hidden, strength, seed)
    assert (diagnosed.verdict, diagnosed.named) == ("unknown_effect", ())


@pytest.mark.parametrize("strength", [0.003, 0.01])
def test_what_leaves_a_law_above_a_known_floor_gets_no_name(strength: float) -> None:
    """A cable that only pulls is half a bilinear stiffness, and half something else."""
    diagnosed = found("one_way_cable", strength, 91000, ("bilinear_stiffness", "quadratic_stiffness"))
    first = diagnosed.decided[0]
    assert first.nats["bilinear_stiffness"] > first.unnamed + 1.0
    assert (diagnosed.verdict, diagnosed.named) == ("unknown_effect", ())


@pytest.mark.parametrize(("strength", "seed"), [(0.0007, 53007), (0.001, 52001)])
def test_a_name_at_a_known_floor_beside_a_law_of_half_its_evidence_is_withheld(
    strength: float, seed: int
) -> None:
    diagnosed = found(
        "one_way_cable", strength, seed, ("bilinear_stiffness", "quadratic_stiffness", "offset_drift")
    )
    assert (diagnosed.verdict, diagnosed.named) == ("unknown_effect", ())


@pytest.mark.parametrize("seed", [514, 522])
def test_a_law_too_small_to_keep_a_name_off_a_known_floor_is_said_beside_it(seed: int) -> None:
    """The sensor is bent by some ten thousandths, and free play of 3 % of the force leaves that."""
    diagnosed = found("freeplay", 0.03, seed, imperfections=("bend",), sensor_pair=seed, lag=0.0)
    assert diagnosed.baseline.adequate(diagnosed.judged)
    assert diagnosed.decided[0].beside > 4.0
    assert (diagnosed.verdict, diagnosed.named) == ("missing_effect", ("freeplay",))
    assert "Besides what is named, something small without a name remains" in diagnosed.caution


@pytest.mark.parametrize(
    ("free_run", "agrees"),
    [(1.0, True), (0.75, True), (1.3, True), (1.8, False), (0.5, False), (-1.0, False)],
)
def test_curves_and_free_run_must_agree_on_a_strength(free_run: float, agrees: bool) -> None:
    effect = SimpleNamespace(term=SimpleNamespace(strength="drag.c2"), strength=1.0)
    whole = SimpleNamespace(values={"drag.c2": SimpleNamespace(value=free_run)})
    assert agree(SimpleNamespace(effects=(effect,)), whole) is agrees  # type: ignore[arg-type]


@pytest.mark.parametrize(("width", "hides"), [(0.4, False), (0.6, True)])
def test_a_guess_that_two_standard_errors_take_to_none_accepts_anything(width: float, hides: bool) -> None:
    sample = draw(None, 0.0, 7, noise_displacement=5e-4)
    prepared = prepare(
        FreeDecay(sample.rate, displacement=sample.displacement[sample.displacement.size // 4 :])
    )
    baseline = fit_baseline((replace(prepared, floor_std=width),), base_model())
    assert not baseline.floor_is_sure
    assert motion_percent(baseline.fit) > 1.0
    assert may_hide_anything(baseline, baseline.fit) is hides


def test_a_floor_known_to_no_better_than_itself_tells_nothing_of_a_large_residual() -> None:
    """A swing read eight times a cycle: nothing above the motion tells the noise, and what is left may be a force."""
    random, time = np.random.default_rng(5), np.arange(160) / 8.0
    noise = 0.03 * np.convolve(random.standard_normal(len(time)), [0.5, 0.7, 0.5], "same")
    u = np.exp(-0.05 * time) * np.cos(2.0 * np.pi * time) + noise
    diagnosed = diagnose(FreeDecay(8.0, displacement=u), library=(find_effect("cubic_stiffness"),))
    assert not diagnosed.baseline.floor_is_sure
    assert diagnosed.verdict == "not_enough_data"
    assert "any model would pass" in diagnosed.explanation
    assert "at rest" in diagnosed.next_experiment
