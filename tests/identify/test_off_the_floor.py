"""Names off the floor: a force whose strength is foretold by the model's own spring needs no law of time refuted."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from identify.diagnosis import off_the_floor
from identify.diagnosis.diagnose import diagnose
from identify.diagnosis.off_the_floor import by_curves, if_foretold, is_foretold
from identify.diagnosis.ranking import Ranked
from identify.diagnosis.suspects import Candidate
from identify.diagnosis.verdict import Judgement
from identify.effects.library import find_effect
from identify.fitting import clear_strength
from identify.fitting.clear_strength import is_clear
from identify.free_decay import FreeDecay
from identify.model.model import Term, base_model
from identify.model.parameter_id import ParameterId

K = 120.0


def candidate(name: str, strength: float, misfit: float) -> Candidate:
    """Return an effect with its strength, fitted so that it leaves a chi-square."""
    term = Term(find_effect(name))
    values = {"linear_stiffness.k": K, str(term.strength): strength}
    fit: Any = SimpleNamespace(
        model=base_model().plus(term),
        parameters={n: SimpleNamespace(value=v) for n, v in values.items()},
        chi_square=misfit,
    )
    return Candidate(term, fit, misfit, 1e4 - misfit, True)


@pytest.mark.parametrize(
    ("name", "strength", "foretold"),
    [
        ("pendulum_stiffness", 124.0, True),
        ("pendulum_stiffness", 112.0, False),
        ("pendulum_stiffness", 127.0, False),
        ("cubic_stiffness", 120.0, False),
    ],
)
def test_gravity_alone_has_the_strength_of_the_linear_spring(name: str, strength: float, foretold: bool):
    assert is_foretold(candidate(name, strength, 1.0)) == foretold


@pytest.mark.parametrize(
    ("gravity", "drift", "clear", "verdict"),
    [
        (124.0, 2.0, True, "missing_effect"),
        (124.0, 2.0, False, "unknown_effect"),
        (160.0, 2.0, True, "unknown_effect"),
        (160.0, 4.0, True, "missing_effect"),
    ],
)
def test_a_drift_forbids_a_name_by_the_free_run_unless_its_strength_was_foretold(
    monkeypatch: pytest.MonkeyPatch, gravity: float, drift: float, clear: bool, verdict: str
):
    """A drift that leaves twice as much is not told apart, four times as much is; what is unclear is not named."""
    monkeypatch.setattr(off_the_floor, "is_clear", lambda fit, term, *, foretold: clear)
    monkeypatch.setattr(off_the_floor, "free_form", lambda baseline, found: None)
    monkeypatch.setattr(off_the_floor, "motion_percent", lambda found: 3.0)
    ranked = tuple(
        Ranked(one, 1.0, 0.0, True)
        for one in (
            candidate("pendulum_stiffness", gravity, 1.0),
            candidate("settling_stiffness", 0.2, drift),
        )
    )
    baseline: Any = SimpleNamespace(fit=SimpleNamespace(chi_square=1e4), floor_is_sure=False)
    said = by_curves(baseline, ranked, None, ranked[0].candidate.fit)
    assert said.verdict == verdict
    if verdict == "missing_effect":
        assert said.ranked[0].candidate.name == "pendulum_stiffness"


@pytest.mark.parametrize(
    ("correlation", "std", "clear"),
    [
        (-0.98, 0.6, True),  # 1/(0.6 sqrt(1 - 0.98^2)) = 8.4 errors once the other is held
        (-0.5, 0.6, False),  # 1.9 errors
        (-0.98, np.inf, False),  # at its bound
    ],
)
def test_a_strength_is_asked_for_with_the_inner_parameters_held(
    monkeypatch: pytest.MonkeyPatch, correlation: float, std: float, clear: bool
):
    """Two normal errors of correlation r: with one held the other's is smaller by sqrt(1 - r^2)."""
    monkeypatch.setattr(clear_strength, "as_white_misfit", lambda found: found)
    term = Term(find_effect("dahl_friction"))
    unknowns = [
        SimpleNamespace(name=f"dahl_friction.{name}", id=ParameterId("dahl_friction", name))
        for name in ("ud", "kd")
    ]
    size = np.array([0.4, 0.6])
    found: Any = SimpleNamespace(
        unknowns=unknowns,
        values={"dahl_friction.kd": SimpleNamespace(value=1.0, std=std)},
        covariance=np.outer(size, size) * np.array([[1.0, correlation], [correlation, 1.0]]),
    )
    assert is_clear(found, term, foretold=True) == clear


@pytest.mark.parametrize(("rivals", "name"), [(("hysteresis",), "hysteresis"), ((), "dahl_friction")])
def test_of_two_laws_that_curves_do_not_tell_apart_the_one_that_reaches_the_floor_is_named(
    monkeypatch: pytest.MonkeyPatch, rivals: tuple[str, ...], name: str
):
    best = Ranked(candidate("hysteresis", 20.0, 1.0), 100.0, 0.0, True)
    best.candidate.fit.reduced = 1.2  # type: ignore[misc]
    confirmed = SimpleNamespace(term=Term(find_effect("dahl_friction")), rivals=rivals)
    found: Any = SimpleNamespace(
        usual=SimpleNamespace(typical=lambda kind: 50.0),
        effects=(confirmed,),
        names=("dahl_friction",),
        mentioned=("dahl_friction", *rivals),
        has_law=lambda effect: True,
    )
    other = Judgement("missing_effect", (Ranked(candidate("dahl_friction", 1.0, 8.0), 1.0, 0.0, True),), None)  # type: ignore[arg-type]
    monkeypatch.setattr(off_the_floor, "is_clear", lambda whole, term, foretold: True)
    monkeypatch.setattr(off_the_floor, "by_curves", lambda *what: other)
    said = if_foretold(
        SimpleNamespace(spread=0.05),  # type: ignore[arg-type]
        Judgement("missing_effect", (best,), best.candidate.fit),
        found,
    )
    assert said.ranked[0].candidate.name == name


def test_a_misfit_that_is_next_to_nothing_is_not_something_missing():
    """An exact viscous decay, written with six digits: far above the noise of its last decade, 1e-4 % of the motion."""
    times = np.arange(300) / 10.0
    pole = complex(-0.25, np.sqrt(4.0 - 0.25**2))
    u = np.array([float(f"{x:.6g}") for x in np.exp(pole * times).real])
    v = np.array([float(f"{x:.6g}") for x in (pole * np.exp(pole * times)).real])
    found = diagnose(FreeDecay(10.0, displacement=u, velocity=v))
    assert not found.baseline.adequate(found.baseline.fit)
    assert (found.verdict, found.named) == ("nothing_missing", ())
    assert "too little to be worth a name" in found.explanation


def test_readings_that_are_lost_are_told_where_the_misfit_is_next_to_nothing():
    time = np.arange(400) / 20.0
    u = np.exp(-0.1 * time) * np.cos(2.0 * np.pi * time)
    u += 1e-6 * np.exp(-0.2 * time) * np.random.default_rng(3).standard_normal(400)
    for place in (40, 41, 42, 90, 91, 150, 151, 152, 153, 200, 201, 202, 250, 251, 300, 301, 302, 303):
        u[place] = u[place - 1]
    names = ("mains_hum", "cubic_stiffness", "quadratic_damping", "dropouts")
    found = diagnose(FreeDecay(20.0, displacement=u), library=tuple(find_effect(name) for name in names))
    assert not found.baseline.adequate(found.baseline.fit)
    assert (found.verdict, found.named) == ("sensor_fault", ("dropouts",))


def test_another_mode_in_the_reading_is_no_force_on_the_first():
    """A beam's second mode, 6.27 times as fast, stands in the accelerometer beside the first: nothing couples the two."""
    random, time, w = np.random.default_rng(1), np.arange(4000) / 500.0, 2.0 * np.pi * 8.0
    first = 0.01 * w**2 * np.exp(-0.3 * time) * np.cos(w * time)
    second = 0.15 * 0.01 * w**2 * np.exp(-2.0 * time) * np.cos(6.27 * w * time + 1.0)
    found = diagnose(
        FreeDecay(500.0, acceleration=first + second + 0.02 * random.standard_normal(len(time))),
        library=tuple(find_effect(n) for n in ("second_mass", "harmonic_forcing", "cubic_stiffness")),
    )
    assert found.named == ()
    assert "not clear of zero" in found.explanation
    assert [mode.frequency for mode in found.modes] == [pytest.approx(50.2, rel=0.02)]


def leads(monkeypatch: pytest.MonkeyPatch, *found: tuple[str, float, float]) -> str | None:
    """Return what leads of forces that reach a guessed floor, each with its evidence and strength."""
    monkeypatch.setattr(off_the_floor, "is_clear", lambda whole, term, foretold: True)
    monkeypatch.setattr(off_the_floor, "free_form", lambda baseline, fit: None)
    ranked = tuple(
        Ranked(candidate(n, strength, 1.0), evidence, 0.0, True) for n, evidence, strength in found
    )
    nothing = Judgement("unknown_effect", ranked, ranked[0].candidate.fit)
    monkeypatch.setattr(off_the_floor, "by_curves", lambda *what: nothing)
    alone = Judgement("missing_effect", ranked, ranked[0].candidate.fit)
    at_floor = SimpleNamespace(spread=0.05, fit=None, adequate=lambda fit: fit.chi_square < 2.0)
    said = if_foretold(at_floor, alone, None)  # type: ignore[arg-type]
    return said.ranked[0].candidate.name if said.verdict == "missing_effect" else None


def test_of_forces_that_a_guessed_floor_does_not_part_the_simplest_leads(monkeypatch: pytest.MonkeyPatch):
    assert leads(monkeypatch, ("hysteresis", 50.0, 1.0), ("cubic_stiffness", 49.0, 1.0)) == "cubic_stiffness"
    assert leads(monkeypatch, ("hysteresis", 50.0, 1.0), ("cubic_stiffness", 44.0, 1.0)) == "hysteresis"


def test_no_force_leads_where_a_law_of_time_is_as_good_but_one_whose_strength_is_foretold(
    monkeypatch: pytest.MonkeyPatch,
):
    drift = ("settling_stiffness", 50.0, 0.1)
    assert leads(monkeypatch, drift, ("cubic_stiffness", 49.0, 1.0)) is None
    assert leads(monkeypatch, drift, ("cubic_stiffness", 40.0, 1.0)) is None  # a drift alone, and one record
    assert leads(monkeypatch, drift, ("pendulum_stiffness", 49.0, K)) == "pendulum_stiffness"
    assert leads(monkeypatch, drift, ("pendulum_stiffness", 49.0, 1.3 * K)) is None


def test_of_a_name_whose_strength_is_unknown_no_numbers_are_stated():
    """A swing so near the bounce of a spring that the amplitude beats: two masses or two modes, it reads alike."""
    random, time = np.random.default_rng(1), np.arange(1800) / 60.0
    bounce = 0.05 * np.exp(-0.03 * time) * np.cos(2.0 * np.pi * 1.2 * time)
    swing = 0.009 * np.exp(-0.02 * time) * np.cos(2.0 * np.pi * 1.02 * time + 1.0)
    found = diagnose(
        FreeDecay(60.0, displacement=bounce + swing + 5e-5 * random.standard_normal(len(time))),
        library=tuple(find_effect(n) for n in ("second_mass", "harmonic_forcing", "cubic_stiffness")),
    )
    assert found.named == ("second_mass",)
    assert "second mass (how strong, this record does not tell)" in found.explanation
    known = {suspect.effect.name: suspect.strength_known for suspect in found.suspects}
    assert not known["second_mass"]
    assert known["cubic_stiffness"]  # of a strength alone the error says all
