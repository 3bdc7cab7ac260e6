"""Releases of one rig whose spring and damper are not quite the same: each has its own, nothing else does."""

import re

import numpy as np
import pytest
from releases import drawn

from identify.diagnosis.diagnose import diagnose
from identify.effects.library import find_effect
from identify.fitting.baseline import fit_baseline
from identify.fitting.fit import fit
from identify.fitting.jacobian import linearise
from identify.fitting.own_linear import centred, with_own_linear
from identify.fitting.problem import Problem
from identify.fitting.segments import segments_of
from identify.fitting.validation import leave_one_out
from identify.judging.releases_differ import release_values, spread_sentence, where_releases_differ
from identify.model.model import base_model

K, MU_1 = 614.0, 0.25
STIFFER = (1.0, 0.996, 1.003)
DAMPED = (1.0, 1.3, 0.8)
AMPLITUDES = (0.02, 0.014, 0.009)
K3 = 4e4
FEW = tuple(
    find_effect(name)
    for name in ("cubic_stiffness", "quadratic_damping", "freeplay", "time_varying_stiffness", "ac_coupling")
)


def releases(hidden=None, stiffer=STIFFER, damped=DAMPED, amplitudes=AMPLITUDES, **others):
    """Return releases of a double whose spring and damper are the given multiples of K and MU_1."""
    pinned = {"parameters": {"cubic_stiffness": {"k3": K3}}} if hidden else {}
    rig = {"mu_0": 0.05, "seconds": 6.0} | others
    return tuple(
        drawn(hidden, 0.01, 70 + i, stiffness=K * k, mu_1=MU_1 * mu, amplitude=a, **pinned, **rig)[0]
        for i, (k, mu, a) in enumerate(zip(stiffer, damped, amplitudes, strict=True))
    )


SPRINGS_DIFFER = 100.0 * float(np.std(STIFFER, ddof=1) / np.mean(STIFFER))
"""Percent."""


def said_to_differ(sentence):
    """Return by how many percent the springs of releases are said to differ."""
    return float(re.search(r"the spring differs by ±([\d.]+) %", sentence).group(1))


def of_each(decays):
    """Return a fit with one spring and damper, and one in which each release has its own."""
    shared = fit_baseline(segments_of(decays), base_model()).fit
    windows = with_own_linear(shared.windows, shared.frequency)
    return shared, fit(shared.model, windows, shared.point, shared.frequency, near=True)


@pytest.fixture(scope="module")
def unlike():
    return of_each(releases())


def test_each_release_has_the_spring_and_damper_that_it_was_made_with(unlike):
    shared, own = unlike
    assert shared.reduced > 100.0
    assert own.reduced == pytest.approx(1.0, abs=0.15)
    values = release_values(own)
    truth = [t for k, mu in zip(STIFFER, DAMPED, strict=True) for t in (K * k, MU_1 * mu)]
    assert [one.index for one in values] == [0, 0, 1, 1, 2, 2]
    assert [one.parameter for one in values[:2]] == ["linear_stiffness.k", "viscous_damping.mu_1"]
    for one, right in zip(values, truth, strict=True):
        assert abs(one.value.value - right) < 4.0 * one.value.std < 0.05 * right


def test_the_shared_value_is_the_mean_and_its_error_that_of_a_mean_of_releases(unlike):
    own = unlike[1]
    k = own.values["linear_stiffness.k"]
    each = [one.value.value for one in release_values(own) if one.parameter == "linear_stiffness.k"]
    assert k.value == pytest.approx(np.mean(each), rel=1e-9)
    assert k.std == pytest.approx(np.std(each, ddof=1) / np.sqrt(3), rel=1e-3)
    assert said_to_differ(spread_sentence(own)) == pytest.approx(SPRINGS_DIFFER, rel=0.05)
    assert spread_sentence(unlike[0]) == ""


def test_in_its_windows_a_release_moves_with_its_own_as_with_the_shared_part(unlike):
    own = unlike[1]
    problem = Problem(own.model, own.windows, own.frequency)
    jacobian = linearise(problem, own.theta)[1]
    held = np.array([u.name == "linear_stiffness.k" for u in own.unknowns])
    alone = linearise(problem, own.theta, skip=held)[1]  # the shared part is not there to be taken
    for number in range(3):
        at = problem.index[f"own_stiffness[{number}]"]
        one = np.eye(len(own.theta))[at]
        column, again = jacobian.change(one), alone.change(one)
        assert np.linalg.norm(column - again) < 1e-3 * np.linalg.norm(column)
        expected = column[-len(problem.expected) :]
        assert np.count_nonzero(expected) == 1
        assert expected.max() == pytest.approx(1.0 / problem.unknowns[at].std)


def test_one_release_has_nothing_beside_what_is_shared():
    shared, own = of_each(releases()[:1])
    k = "linear_stiffness.k"
    assert own.values[k].value == pytest.approx(shared.values[k].value, rel=1e-7)
    assert own.values[k].std == pytest.approx(shared.values[k].std, rel=0.01)
    assert own.values["own_stiffness"].value == pytest.approx(0.0, abs=1e-9)


def test_the_pieces_of_a_long_release_share_its_spring():
    rig = {"mu_0": 0.02, "seconds": 24.0}
    decays = releases(stiffer=(1.0, 1.004), damped=(0.2, 0.2), amplitudes=(0.02, 0.018), **rig)
    own = of_each(decays)[1]
    assert [window.release for window in own.windows] == [0, 0, 1, 1]
    assert own.reduced == pytest.approx(1.0, abs=0.15)
    first, second = (one for one in release_values(own) if one.parameter == "linear_stiffness.k")
    assert second.value.value / first.value.value == pytest.approx(1.004, abs=1e-4)
    spring = "linear_stiffness.k"
    assert own.of_release(2)[spring] == own.of_release(3)[spring] != own.of_release(0)[spring]
    assert own.of_release(3)["linear_stiffness.k"] == pytest.approx(second.value.value)


def test_a_release_that_was_left_out_is_predicted_with_its_own_spring(unlike):
    shared, own = unlike
    assert min(one.chi_square for one in leave_one_out(shared)) > 30.0
    assert [one.chi_square for one in leave_one_out(own)] == pytest.approx([1.0] * 3, abs=0.4)


def test_nothing_is_missing_where_only_spring_and_damper_differ():
    found = diagnose(releases(), library=FEW)
    assert found.verdict == "nothing_missing"
    assert said_to_differ(found.explanation) == pytest.approx(SPRINGS_DIFFER, rel=0.05)
    assert "the viscous damping differs by ±" in found.explanation
    assert len(found.of_releases) == 6
    again = diagnose(found.decays, library=FEW)  # what was decided is kept with the releases
    assert again.verdict == "nothing_missing"
    assert again.final.reduced == pytest.approx(found.final.reduced, rel=1e-3)


@pytest.mark.slow
def test_an_effect_is_named_with_its_strength_though_the_springs_differ():
    found = diagnose(releases("cubic_stiffness"), library=FEW)
    assert found.named == ("cubic_stiffness",)
    k3 = found.final.values["cubic_stiffness.k3"]
    assert abs(k3.value - K3) < 4.0 * k3.std < 0.05 * K3
    springs = [one.percent for one in found.of_releases if one.parameter == "linear_stiffness.k"]
    assert springs == pytest.approx([100.0 * (k / np.mean(STIFFER) - 1.0) for k in STIFFER], abs=0.02)


@pytest.mark.slow
def test_an_effect_of_the_amplitude_does_not_hide_in_the_springs():
    alike = (1.0, 1.0, 1.0)
    decays = releases("cubic_stiffness", alike, alike, amplitudes=(0.02, 0.01, 0.005))
    usual = fit_baseline(segments_of(decays), base_model())
    assert where_releases_differ(usual) is not usual  # softer at small amplitudes, they seem to differ
    found = diagnose(decays, library=FEW)
    assert found.named == ("cubic_stiffness",)
    assert found.of_releases == ()
    assert found.final.values["cubic_stiffness.k3"].value == pytest.approx(K3, rel=0.01)


def test_releases_that_share_their_physics_are_left_as_they_are():
    alike = (1.0, 1.0, 1.0)
    usual = fit_baseline(segments_of(releases(None, alike, alike)), base_model())
    assert where_releases_differ(usual) is usual
    one = fit_baseline(segments_of(releases()[:1]), base_model())
    assert where_releases_differ(one) is one


def test_the_mean_damper_is_that_of_what_the_motion_has_of_each_release_never_below_its_bound():
    pieces = segments_of(releases()[:2])
    base = fit_baseline(pieces, base_model()).fit
    problem = Problem(base.model, with_own_linear(base.windows, base.frequency), base.frequency)
    shared = problem.index["viscous_damping.mu_1"]
    own = problem.deviations[shared]
    theta = problem.theta(base.point)
    theta[shared], theta[own] = 0.01, (-0.05, 0.02)  # in the motion 0 and 0.03
    stated, _, _ = centred(problem, theta, np.eye(len(theta)))
    assert stated[shared] == pytest.approx(0.015)
    assert stated[own] == pytest.approx([-0.015, 0.015])
