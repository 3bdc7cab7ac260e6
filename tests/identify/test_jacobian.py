import numpy as np
import pytest
from releases import drawn

from identify.effects.library import find_effect
from identify.fitting.initial_values import initial_values
from identify.fitting.jacobian import linearise
from identify.fitting.problem import Problem
from identify.model.model import Term, base_model


def problem_and_point(name, **inner):
    prepared, _ = drawn(name, 0.03, 7100)
    term = Term(find_effect(name))
    model = base_model().plus(term)
    problem = Problem(model, (prepared.window,), prepared.frequency)
    start = initial_values((prepared,), model, term.by_name(inner))
    return problem, np.clip(problem.theta(start), problem.low, problem.high)


@pytest.mark.parametrize(
    ("name", "inner"),
    [("cubic_stiffness", {}), ("freeplay", {"gap": 5e-4}), ("maxwell_element", {"tau": 0.03})],
)
def test_slopes_from_longer_steps_are_those_of_the_motion(name, inner):
    problem, theta = problem_and_point(name, **inner)
    assert problem.substeps(theta, 0, tangent=True) < problem.substeps(theta, 0)
    _, jacobian = linearise(problem, theta)
    for j, unknown in enumerate(problem.unknowns):
        step = np.zeros(len(theta))
        step[j] = 10.0 * problem.steps[j]
        there, back = problem.residuals(theta + step), problem.residuals(theta - step)
        slope = (there - back) / (2.0 * step[j])
        moves = np.abs(there - back) < 0.5  # a reading that friction's reversal crosses has no slope
        gap = (jacobian.change(np.eye(len(theta))[j]) - slope)[moves]
        assert np.linalg.norm(gap) < 0.05 * np.linalg.norm(slope[moves]), unknown.name


def test_the_slope_of_dry_friction_is_the_same_where_there_is_none():
    prepared, _ = drawn(None, 0.0, 7100)
    problem = Problem(base_model(), (prepared.window,), prepared.frequency)
    theta = problem.theta(initial_values((prepared,), problem.model, {}))
    mu_0 = problem.index["coulomb_friction.mu_0"]
    slopes = []
    for friction in (0.0, 1e-6):
        theta[mu_0], problem.steps[:] = friction, 0.0
        slopes.append(linearise(problem, theta)[1].change(np.eye(len(theta))[mu_0]))
    assert np.linalg.norm(slopes[0] - slopes[1]) < 0.01 * np.linalg.norm(slopes[1])


def test_a_start_that_changes_and_changes_back_moves_its_window_once(monkeypatch):
    prepared, _ = drawn("cubic_stiffness", 0.03, 7100)
    model, windows = base_model(), (prepared.window, prepared.window.with_(release=1))
    problem = Problem(model, windows, prepared.frequency)
    theta = problem.theta(initial_values((prepared, prepared), model, {}))
    moved = theta.copy()
    (start,) = [u for u in problem.unknowns if u.window == 1 and u.id.parameter == "displacement"]
    moved[problem.index[start.name]] += 1e-5
    before = problem.residuals(theta)
    simulated, respond = [], problem.respond
    monkeypatch.setattr(problem, "respond", lambda *a: simulated.append(a[1]) or respond(*a))
    after, again = problem.residuals(moved), problem.residuals(theta)
    assert simulated == [1]
    np.testing.assert_array_equal(again, before)
    half = len(before) // 2
    np.testing.assert_array_equal(after[:half], before[:half])
    assert np.max(np.abs(after[half:] - before[half:])) > 1.0
    np.testing.assert_array_equal(after, Problem(model, windows, prepared.frequency).residuals(moved))
