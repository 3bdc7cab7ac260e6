"""Families: their members are the library's effects, and the exponent of a hidden law is found."""

import numpy as np
import pytest
from releases import drawn
from scipy.integrate import solve_ivp
from scipy.special import gamma

from identify.diagnosis.diagnose import diagnose
from identify.effects.families import BOUC_WEN, FAMILIES, LUGRE, POWER_LAW_DAMPING, POWER_LAW_STIFFNESS
from identify.effects.library import LIBRARY, find_effect
from identify.fitting.baseline import fit_baseline
from identify.fitting.initial_values import scales_of
from identify.free_decay import FreeDecay
from identify.judging.suspects import laws_of_families, try_terms
from identify.model.equivalent_linearisation import average
from identify.model.model import Term, base_model

W, A = 24.78, np.array([0.004, 0.012, 0.023])


def test_families_are_no_suspects_and_their_members_are():
    names = {effect.name for effect in LIBRARY}
    for family in FAMILIES:
        assert family.effect.name not in names
        assert set(family.members) <= names
        exponent = family.effect.parameters[family.effect.index(family.free)]
        assert all(exponent.low <= value <= exponent.high for value in family.members.values())


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.effect.name)
def test_a_member_is_the_family_at_its_exponent(family):
    """In proportion: their strengths are measured differently."""
    for name, exponent in family.members.items():
        member = find_effect(name)
        values = {"f": 1.3, "at": 0.02, "kh": 1.3, "uy": 0.004, "kd": 1.3, "ud": 0.004, "vs": 0.1}
        values[family.free] = exponent
        law = average(family.effect, {p.name: values[p.name] for p in family.effect.parameters}, W, A)
        there = average(member, {p.name: values.get(p.name, 1.0) for p in member.parameters}, W, A)
        for mine, its in ((law.damping, there.damping), (law.stiffening, there.stiffening)):
            if abs(its[0]) > 1e-6:
                np.testing.assert_allclose(mine / mine[0], its / its[0], rtol=1e-5)


@pytest.mark.parametrize("p", [1.5, 3.3])
def test_the_signature_of_a_power_law_is_that_of_the_gamma_function(p):
    """The mean of |cos|^q over a cycle is gamma((q + 1)/2)/(sqrt(pi) gamma(q/2 + 1))."""
    mean = gamma((p + 2) / 2) / (np.sqrt(np.pi) * gamma((p + 1) / 2 + 1))
    spring = average(POWER_LAW_STIFFNESS.effect, {"f": 0.3, "p": p, "at": 0.01}, W, A)
    np.testing.assert_allclose(spring.stiffening, 2 * 0.3 * (A / 0.01) ** p / A * mean, rtol=1e-4)
    damper = average(POWER_LAW_DAMPING.effect, {"f": 0.3, "p": p, "at": 0.2}, W, A)
    np.testing.assert_allclose(damper.damping, 2 * 0.3 * (A * W / 0.2) ** p / (A * W) * mean, rtol=1e-4)


def test_the_nearest_member_is_told():
    assert POWER_LAW_DAMPING.nearest(1.9) == "quadratic_damping"
    assert POWER_LAW_STIFFNESS.nearest(4.4) == "quintic_stiffness"
    assert (
        POWER_LAW_DAMPING.nearest(1.4, base_model().names) == "quadratic_damping"
    )  # the model has viscous damping
    assert BOUC_WEN.nearest(1.0, ("hysteresis",)) is None


@pytest.mark.parametrize(
    ("hidden", "family", "exponent"),
    [
        ("quadratic_damping", POWER_LAW_DAMPING, 2.0),
        ("power_law_damping", POWER_LAW_DAMPING, None),
        pytest.param("power_law_stiffness", POWER_LAW_STIFFNESS, None, marks=pytest.mark.slow),
        pytest.param("bouc_wen_hysteresis", BOUC_WEN, None, marks=pytest.mark.slow),
        ("lugre_friction", LUGRE, None),
    ],
)
def test_the_exponent_of_a_hidden_law_is_found(hidden, family, exponent):
    prepared, truth = drawn(hidden, 0.02, seed=51)
    baseline = fit_baseline((prepared,), base_model())
    term = Term(family.effect, family.held(scales_of(prepared, {})))
    found = try_terms(baseline.decays, baseline.fit, (term,))[0].fit
    p = found.of(term)[family.free]
    true = truth["parameters"][family.free] if exponent is None else exponent
    assert found.reduced < 1.3  # the floor of a single record is known to some 6 %, and the noise to 1.2 here
    assert abs(p.value - true) < 4.0 * p.std  # 1 in 16000 by chance
    assert p.std < 0.15


@pytest.mark.parametrize("family", [POWER_LAW_STIFFNESS, POWER_LAW_DAMPING], ids=lambda f: f.effect.name)
def test_a_power_law_is_in_proportion_to_its_strength_of_either_sign(family):
    values = {"at": 0.02, family.free: 2.5}
    soft, hard = (average(family.effect, values | {"f": f}, W, A) for f in (-0.6, 0.6))
    np.testing.assert_allclose(soft.stiffening + soft.damping, -(hard.stiffening + hard.damping), rtol=1e-9)


@pytest.mark.slow
def test_a_softening_law_between_the_names_is_told_as_one_law_and_no_pair_is_made_up():
    prepared, truth = drawn("power_law_stiffness", 0.03, seed=62200)
    assert truth["parameters"]["f"] < 0.0
    found = diagnose(prepared)
    assert found.named == ("power_law_stiffness",)
    p = found.final.values["power_law_stiffness.p"]
    assert abs(p.value - truth["parameters"]["p"]) < 4.0 * p.std  # 1 in 16000 by chance


RIVALS = ("quadratic_damping", "cubic_damping", "fading_damping", "fading_friction", "cubic_stiffness",
          "signed_quadratic_stiffness", "settling_stiffness", "end_stop")  # fmt: skip


@pytest.mark.parametrize(
    ("law", "seed", "hum"),
    [("power_law_damping", 5, 0.0), ("power_law_stiffness", 3, 0.0), ("power_law_damping", 5, 1e-3)],
)
def test_a_power_between_the_names_is_no_member_and_no_law_of_time_though_the_noise_is_a_guess(
    law, seed, hum
):
    """A force that grows with the power 1.5 of speed or displacement: drag between laminar and turbulent flow, a contact."""
    w, start, p = 8.2, 0.03, 1.5

    def rates(_, y):
        u, v = y
        drag = (
            0.12 * w * start * abs(v / (w * start)) ** p * np.sign(v) if law == "power_law_damping" else 0.0
        )
        spring = (
            0.03 * w**2 * start * abs(u / start) ** p * np.sign(u) if law == "power_law_stiffness" else 0.0
        )
        return [v, -(w**2) * u - 0.02 * v - drag - spring]

    time = np.arange(2500) / 100.0
    run = solve_ivp(rates, (0.0, time[-1]), [start, 0.0], t_eval=time, rtol=1e-9, atol=1e-12)
    noise = 2e-5 * np.random.default_rng(seed).standard_normal(len(time))
    line = hum * np.sin(2 * np.pi * 17.3 * time)
    library = tuple(map(find_effect, (*RIVALS, "mains_hum")))
    found = diagnose(FreeDecay(100.0, run.y[0] + noise + line), library=library)
    assert (found.baseline.floor_is_sure, found.named) == (False, (law, "mains_hum") if hum else (law,))
    exponent = found.final.values[f"{law}.p"]
    assert abs(exponent.value - p) < 4.0 * exponent.std  # 1 in 16000 by chance


def test_a_law_of_a_family_begins_at_its_members():
    """Its strength is that of the member's force: at the member's exponent both leave the same."""
    prepared, _ = drawn("cubic_stiffness", 0.02, seed=52, seconds=4.0)
    baseline = fit_baseline((prepared,), base_model())
    members = try_terms(baseline.decays, baseline.fit, (Term(find_effect("cubic_stiffness")),))
    law = laws_of_families(baseline, [members[0].name])[0]
    assert law.fit.chi_square <= members[0].fit.chi_square + 0.1  # one more number cannot leave more
    assert law.fit.values["power_law_stiffness.p"].value == pytest.approx(3.0, abs=0.1)
    with_law = fit_baseline((prepared,), law.fit.model, law.fit.point)
    assert laws_of_families(with_law, [members[0].name]) == ()  # it is in the model already
