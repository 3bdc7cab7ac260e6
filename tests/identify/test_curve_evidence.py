"""What evidence decides, and the marginal likelihood of curves against the same Gaussian written out in full."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.stats import multivariate_normal
from specimens import among

from identify.curves.confirm import Curves
from identify.curves.curve_laws import CurveLaws
from identify.curves.isolated_mode import isolated
from identify.curves.likelihood import Added, CurveLikelihood
from identify.diagnosis.diagnose import diagnose
from identify.effects.library import LIBRARY, find_effect
from identify.evidence import complexity, decide
from identify.fitting.initial_values import scales_of
from identify.free_decay import FreeDecay
from identify.judging.suspects import candidate_terms
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import PreparedDecay, prepare
from identify.priors import SIZES
from mocks.generate import draw

NAMES = (
    "cubic_stiffness",
    "quintic_stiffness",
    "end_stop",
    "quadratic_damping",
    "cubic_damping",
    "position_dependent_damping",
    "settling_stiffness",
    "time_varying_stiffness",
)


def decided(without_name: dict | None = None, **nats: float):
    """Return what the evidence for some effects decides, beside effects that nothing speaks for."""
    given = {name: nats.get(name, -20.0) for name in NAMES}
    return decide(given, {name: find_effect(name) for name in NAMES}, **(without_name or {}))


def test_the_likeliest_law_is_named_and_one_as_likely_is_its_rival():
    assert (decided(cubic_stiffness=12.0).verdict, decided(cubic_stiffness=12.0).names) == (
        "named",
        ("cubic_stiffness",),
    )
    assert decided(cubic_stiffness=12.0, quintic_stiffness=11.0).names == (
        "cubic_stiffness",
        "quintic_stiffness",
    )
    assert decided(cubic_stiffness=12.0, quintic_stiffness=4.0).names == ("cubic_stiffness",)


def test_nothing_is_named_that_may_be_none_or_a_drift_or_any_of_many():
    assert decided(cubic_stiffness=2.0).verdict == "nothing"
    assert decided().names == ()
    assert decided(cubic_stiffness=12.0, settling_stiffness=10.0).verdict == "may drift"
    assert decided(cubic_stiffness=20.0, settling_stiffness=10.0).verdict == "named"
    many = dict.fromkeys(NAMES[:6], 12.0)
    assert decided(**many).verdict == "too many"
    assert set(decided(**many).names) == set(many)


def test_a_law_without_a_name_is_a_rival_of_all():
    assert decided({"unnamed": 16.0}, cubic_stiffness=20.5).verdict == "named"
    assert decided({"unnamed": 17.0}, cubic_stiffness=20.5).verdict == "no name"


def test_a_law_of_time_is_named_where_a_drift_is_part_of_every_hypothesis():
    assert decided(settling_stiffness=12.0).verdict == "may drift"
    assert decided({"drift_weighed": True}, settling_stiffness=12.0).verdict == "named"


def test_evidence_that_differs_in_its_last_digits_decides_the_same():
    one, other = (
        decided(cubic_stiffness=12.0, quintic_stiffness=12.0 + 1e-9),
        decided(cubic_stiffness=12.0, quintic_stiffness=12.0),
    )
    assert one.names == other.names == ("cubic_stiffness", "quintic_stiffness")


def test_gravity_on_an_angle_is_simpler_than_any_law_with_a_constant_of_its_own():
    others = [effect for effect in LIBRARY if effect.name != "pendulum_stiffness"]
    assert all(complexity(find_effect("pendulum_stiffness")) < complexity(effect) for effect in others)


def displacement_only(name: str | None, strength: float, seed: int, **setting: object) -> PreparedDecay:
    """Return a release of the double without its second channel: its floor can only be guessed."""
    sample = draw(name, strength, seed, **setting)
    return prepare(FreeDecay(sample.rate, displacement=sample.displacement))


@pytest.fixture(scope="module")
def likelihood() -> CurveLikelihood:
    decay = displacement_only("quadratic_damping", 0.03, 11, amplitude=0.02, mu_0=0.01)
    terms = candidate_terms(base_model(), tuple(find_effect(name) for name in NAMES[:4]), decay.window)
    laws = CurveLaws.of(isolated([decay]), base_model(), {}, terms, scales_of(decay, {}))
    return CurveLikelihood(laws)


@pytest.mark.parametrize("settings", [(0, 0, 0, 0, 0, 0), (3, 2, 0, 0, 1, 2), (2, 0, 4, 3, 0, 0)])
def test_the_likelihood_is_that_of_one_normal_distribution_of_all_points(
    likelihood: CurveLikelihood, settings: tuple[int, ...], monkeypatch: pytest.MonkeyPatch
):
    """What a law adds, against the density of the points with all that is unknown written into one covariance.

    The start is free: differences between neighbours have no part in it. Spring, friction and damper are given a prior of
    a hundredth of the spring, and the noise is that of a bench, so that double precision is enough for the covariance.
    """
    flat, noise = 0.01, (1e-3, 1e-3, 1e-3, 1e-6)
    monkeypatch.setattr("identify.curves.likelihood.FLAT", flat)
    monkeypatch.setattr(likelihood, "noise", noise)
    column = len(likelihood.base)
    law = Added().and_law(column, 0.03 * float(likelihood.laws.natural[column]))
    products = likelihood.products(likelihood.observed, [column])
    gained = likelihood._nats(products, law, settings) - likelihood._nats(products, Added(), settings)
    (rig,), laws = likelihood.rigs, likelihood.laws
    n, channels = len(rig.curve), len(likelihood.channels)

    def dense(added: Added) -> float:
        scales = [*(flat * likelihood.laws.natural[list(likelihood.base)]), *added.scales]
        covariance = np.zeros((channels * n, channels * n))
        for channel in likelihood.channels:
            part = slice(channel * n, (channel + 1) * n)
            walk, nameless = SIZES[settings[2 * channel]], SIZES[settings[2 * channel + 1]]
            own = rig.covariance(channel, noise, float(walk))
            shapes = likelihood.shapes[0][channel]
            covariance[part, part] += own + nameless**2 * shapes @ shapes.T
        for scale, c in zip(scales, likelihood.columns(added), strict=True):
            moved = np.concatenate([laws.columns[0][channel][:, c] for channel in likelihood.channels])
            covariance += scale**2 * np.outer(moved, moved)
        differences = np.kron(np.eye(channels), np.diff(np.eye(n), axis=0))
        points = differences @ np.concatenate(likelihood.observed[0])
        return float(multivariate_normal.logpdf(points, cov=differences @ covariance @ differences.T))

    assert gained == pytest.approx(dense(law) - dense(Added()), abs=1e-3)


def test_a_one_sided_spring_is_known_by_its_centre_and_not_taken_for_a_softening_one():
    release = displacement_only("quadratic_stiffness", 0.15, 4, amplitude=0.02, mu_0=0.01)
    softening = ("cubic_stiffness", "signed_quadratic_stiffness", "settling_stiffness", "hysteresis")
    found = diagnose(release, library=among("quadratic_stiffness", *softening, "quadratic_damping"))
    assert found.named == ("quadratic_stiffness",)


def swinging(seconds: float, drag: float) -> PreparedDecay:
    """Return the angle of a pendulum from 0.9 rad, with viscous and quadratic damping, read to 0.2 mrad at 50 Hz."""

    def rates(_: float, y: np.ndarray) -> list[float]:
        return [y[1], -28.0 * np.sin(y[0]) - 0.02 * y[1] - drag * abs(y[1]) * y[1]]

    time = np.arange(round(50.0 * seconds)) / 50.0
    motion = solve_ivp(rates, (0.0, seconds), [0.9, 0.0], t_eval=time, rtol=1e-9, atol=1e-12)
    noise = 2e-4 * np.random.default_rng(3).standard_normal(len(time))
    return prepare(FreeDecay(50.0, displacement=motion.y[0] + noise, unit="rad"))


def test_gravity_and_drag_are_both_named_though_one_force_with_memory_would_move_both():
    """Hysteresis moves loss and frequency at once, and is likelier than gravity alone, or drag alone; not than the pair."""
    rivals = ("hysteresis", "cubic_stiffness", "settling_stiffness", "fading_damping")
    found = diagnose(swinging(30.0, 0.02), library=among("pendulum_stiffness", "quadratic_damping", *rivals))
    assert set(found.named) == {"pendulum_stiffness", "quadratic_damping"}


def test_a_release_that_sways_does_not_hide_what_three_share():
    """Of three releases of one hard spring the first is read by a clock that sways by 12 ms (0.3 rad) in 3 s."""
    decays = []
    for i, amplitude in enumerate((0.02, -0.015, 0.01)):
        sample = draw(
            "cubic_stiffness",
            0.03,
            20 + i,
            amplitude=amplitude,
            mu_0=0.02,
            parameters={"cubic_stiffness": {"k3": 1.2e5}},
        )
        time = np.arange(len(sample.displacement)) / sample.rate
        sway = 0.012 * np.sin(2.0 * np.pi * time / 3.0) if i == 0 else 0.0
        swayed = np.interp(time + sway, time, sample.displacement)
        decays.append(prepare(FreeDecay(sample.rate, displacement=swayed)))
    terms = candidate_terms(base_model(), LIBRARY, decays[0].window)
    found = Curves(tuple(decays), base_model(), {}, terms, scales_of(decays[0], {})).confirmation
    assert found is not None
    assert set(found.names) <= {"cubic_stiffness"}


@pytest.mark.parametrize("seed", [3, 4])
def test_a_law_of_time_that_is_far_behind_is_no_rival_of_a_name_that_the_curves_confirm(seed: int):
    record = draw("freeplay", 0.1, seed)
    found = diagnose(
        FreeDecay(record.rate, record.displacement),
        library=among("freeplay", "end_stop", "time_varying_stiffness", "cubic_stiffness", "fading_friction"),
    )
    assert found.named == ("freeplay",)
    assert found.suspects[0].confirmed is not None
    assert set(found.suspects[0].rivals) <= {"end_stop"}  # the same law by another name
