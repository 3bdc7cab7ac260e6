"""A spring and damper that walk at random: how strong a walk is found, and that no law is named that only follows one."""

from functools import cache

import pytest
from releases import ready
from specimens import among, diagnosed

from identify.diagnosis.diagnose import diagnose
from identify.fitting.baseline import fit_baseline
from identify.fitting.random_walk import walk_beside, with_walk_errors
from identify.judging.beside_walk import smooth_law_evidence
from identify.model.model import base_model
from mocks.generate import draw

SPRINGS = among(
    "cubic_stiffness", "signed_quadratic_stiffness", "settling_stiffness", "time_varying_stiffness", "hysteresis"
)  # fmt: skip


def release(hidden, strength, seed):
    sample = draw(hidden, strength, seed)
    return ready(sample.rate, sample.displacement, sample.acceleration), sample.truth


def walk(truth, name):
    """Return the standard deviation of a hidden walk after one second, relative."""
    parameters = truth["parameters"]
    return parameters.get(name, parameters)["s"]


@pytest.mark.parametrize(
    ("name", "found"), [("wandering_stiffness", "stiffness"), ("wandering_damping", "damping")]
)
def test_the_strength_of_a_walk_is_found(name, found):
    prepared, truth = release(name, 0.0003, 1)
    wander = fit_baseline((prepared,), base_model()).walk
    assert wander.evidence > 10.0
    assert wander.reduced < 1.1
    # One walk of eight seconds tells its strength to about a factor of two.
    assert 1.0 / 3.0 < getattr(wander, found) / walk(truth, name) < 3.0


def test_white_noise_shows_no_wander():
    prepared, _ = release(None, 0.0, 4)
    wander = fit_baseline((prepared,), base_model()).walk
    assert wander.evidence < 0.0  # the odds are against one


@pytest.mark.slow
def test_no_law_is_named_that_follows_a_walk():
    found = diagnosed(release("wandering_damping", 0.0003, 1)[0])
    assert found.verdict == "unknown_effect"
    assert found.named == ()
    assert found.suspects[0].claimed  # by chi-square alone it is beyond chance


@pytest.mark.slow
def test_a_line_does_not_vouch_for_a_law_that_follows_a_walk_beside_it():
    prepared, _ = release("wandering_stiffness+mains_hum", (0.0003, 0.003), 4)
    named = diagnosed(prepared).named
    assert not set(named) - {"mains_hum", "harmonic_forcing"}


def test_what_is_not_told_from_a_wander_is_said_with_its_size():
    prepared, _ = release("wandering_stiffness", 0.0003, 1)
    found = diagnose(prepared, library=SPRINGS)
    assert (found.verdict, found.named) == ("unknown_effect", ())
    assert found.walk is not None
    assert found.walk.stiffness > 0.0
    assert (
        "a random walk in stiffness of about 0.01 % in one second explains the residual" in found.explanation
    )
    assert "together" in found.next_experiment


@pytest.mark.slow
def test_a_strong_walk_is_not_named_after_the_law_that_follows_most_of_it():
    assert diagnosed(release("wandering_stiffness", 0.01, 11300)[0]).named == ()


def test_a_law_alone_leaves_neither_a_wander_nor_a_law_without_a_name():
    prepared, _ = release("cubic_stiffness", 0.003, 7)
    found = diagnose(prepared, library=SPRINGS)
    assert found.named == ("cubic_stiffness",)
    beside = walk_beside(found.final)
    assert max(beside.evidence, smooth_law_evidence(beside)) < 0.0
    alone = fit_baseline((prepared,), base_model()).walk
    assert 0.0 < alone.evidence + smooth_law_evidence(alone) < found.suspects[0].evidence


@pytest.mark.slow
def test_no_law_is_named_that_follows_one_that_the_library_does_not_hold():
    found = diagnosed(release("amplitude_switched_damping", 0.003, 300)[0])
    assert (found.verdict, found.named) == ("unknown_effect", ())
    assert found.suspects[0].claimed


@pytest.mark.slow
@pytest.mark.parametrize(("name", "seed"), [("fading_friction", 300), ("fading_damping", 301)])
def test_a_loss_that_fades_with_time_is_no_walk_and_does_not_depend_on_the_amplitude(name, seed):
    found = diagnosed(release(name, 0.003, seed)[0], also=name)
    assert found.named == (name,)
    assert found.walk is None


@cache
def beside(name, walk_of, seed):
    """Return what is diagnosed of a law beside a strong walk, and the truth."""
    prepared, truth = release(f"{name}+{walk_of}", (0.03, 0.003), seed)
    return diagnosed(prepared, also=name), truth


CUBIC = ("cubic_stiffness", "wandering_stiffness", 41000)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "walk_of", "seed"), [("stribeck_friction", "wandering_damping", 41005), CUBIC]
)
def test_a_law_is_named_beside_a_walk_that_keeps_it_far_from_the_floor(name, walk_of, seed):
    """Springs and dampers drift: what is named, and how well it is known, must allow for that."""
    found, truth = beside(name, walk_of, seed)
    assert found.named == (name,)
    assert found.final.reduced > 2.0
    assert found.walk is not None
    assert found.walk.reduced < found.baseline.highest
    assert "a random walk in" in found.caution
    stated = found.baseline.stated(found.final).values
    known = {
        f"{name}.{p}": value for p, value in truth["parameters"][name].items() if isinstance(value, float)
    }
    for unknown, value in (known | {"linear_stiffness.k": truth["stiffness_per_mass"]}).items():
        if unknown in stated:
            assert abs(stated[unknown].value - value) < 4.0 * stated[unknown].std


@pytest.mark.slow
def test_what_remains_beside_a_drift_is_said_to_be_one():
    steps = beside(*CUBIC)[0].refine()
    assert [step.added for step in steps.steps[1:]] == ["cubic_stiffness"]
    assert "random walk" in steps.stopped_because


def test_a_walk_is_followed_beyond_where_the_motion_is_linear_in_it():
    """Taken as linear, a walk that turns the phase leaves a misfit that a law could be named for."""
    fitted = fit_baseline((release("wandering_stiffness", 0.003, 31005)[0],), base_model())
    linear, followed = fitted.walk, fitted.walk.simulated
    assert linear.reduced > 1.5
    assert followed.settled
    assert followed.reduced < 1.2


def test_noise_whose_colour_is_hardly_known_is_no_force():
    """A record with nothing hidden, found by drawing 91: with the colour taken as known a Maxwell element gains 41 nats."""
    sample = draw(
        None, 0.0, 906128, stiffness=599.14, mu_0=0.0, mu_1=1.6788, amplitude=-0.018425, rate=123.42, seconds=9.2012,
        range_displacement=0.03685, range_acceleration=22.078, noise_displacement=1.8637e-5,
        noise_acceleration=0.011166, gain_error=0.0, imperfections=("one_over_f",), sensor_pair=906128,
    )  # fmt: skip
    laws = among("maxwell_element", "hysteresis", "cubic_stiffness", "quadratic_damping")
    prepared = ready(sample.rate, sample.displacement, sample.acceleration)
    assert diagnose(prepared, library=laws).named == ()


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
def test_a_suspect_whose_motion_diverges_is_weighed_without_a_warning():
    """The motion of the Maxwell element diverges with the steps at which the walk's responses are simulated."""
    found = diagnosed(release("one_sided_friction", 0.01, 61019)[0], also="maxwell_element")
    assert found.verdict == "unknown_effect"


@pytest.mark.parametrize("seed", [4, 6])
def test_errors_beside_a_walk_are_no_wider_where_there_is_no_dry_friction(seed):
    """As in the covariance, an unknown at its bound is free: were it held here, the other's error would be 40 times this."""
    sample = draw("wandering_damping", 0.001, seed, mu_0=0.0)
    found = fit_baseline((ready(sample.rate, sample.displacement, sample.acceleration),), base_model())
    stated = with_walk_errors(found.fit, found.walk).parameters
    assert stated["coulomb_friction.mu_0"].value == 0.0
    loss = stated["viscous_damping.mu_1"]
    assert loss.std > 10.0 * found.fit.parameters["viscous_damping.mu_1"].std
    assert loss.std < 0.5 * loss.value
