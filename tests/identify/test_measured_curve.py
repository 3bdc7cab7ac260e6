"""The measured curve: its splines against scipy's, its force in the simulator, and a known spring found without a name."""

import numpy as np
import pytest
from releases import drawn
from scipy.interpolate import BSpline

from identify.diagnosis.ladder import add_effect, step_of
from identify.effects.user import parse_effect
from identify.effects.user.measured_curve import CurveForm, read_curve
from identify.fitting.baseline import fit_baseline
from identify.judging.nonparametric_force import curve_of_rest
from identify.model.model import base_model

VALUES = {"a": 2.0, "r1": 0.3, "r2": -0.4, "r3": 0.5, "r5": -0.6, "r6": 0.7}


def test_the_basis_is_that_of_cubic_splines_with_five_intervals():
    form = CurveForm("", "u", -0.03, 0.02, 1)
    position = np.linspace(-0.03, 0.02, 301)
    knots = np.arange(-3, 9) * 0.01 - 0.03
    all_of_them = BSpline.design_matrix(np.clip(position, -0.03, 0.02 - 1e-12), knots, 3).toarray()
    assert form.basis(position) == pytest.approx(all_of_them[:, 1:7], abs=1e-9)


@pytest.mark.parametrize(
    "formula",
    ["sgn(v)*spline(abs(v), 0, 2, 4)", "v * spline(t, 0, 1, 4)"],
)
def test_a_line_is_read_as_it_is_written_and_gives_the_sum_of_its_splines(formula):
    form = read_curve(formula)
    assert read_curve(form.formula) == form
    effect = parse_effect(f"own = {form.formula}")
    random = np.random.default_rng(4)
    time, u, v = np.sort(random.uniform(0, 3, 50)), random.uniform(-2, 2, 50), random.uniform(-2, 2, 50)
    weights = 2.0 * np.array([0.3, -0.4, 0.5, 1.0, -0.6, 0.7])
    states = effect.states_along(effect.table(VALUES, {}), time, u, v, (0.0, 0.0))
    found = effect.force_along(effect.table(VALUES, {}), time, u, v, states)
    assert found == pytest.approx(form.along(time, u, v) @ weights, abs=1e-12)


@pytest.mark.parametrize("formula", ["spline(u, 1, 1, 4)", "spline(u, a, 1, 4)", "spline(u, -inf, 1, 2)"])
def test_a_spline_without_two_ends_is_refused(formula):
    with pytest.raises(ValueError, match="spline"):
        parse_effect(f"own = {formula}")


def test_another_formula_is_no_curve():
    assert read_curve("a*u**3") is None


@pytest.mark.slow
def test_a_spring_that_is_known_to_the_double_is_found_as_a_curve():
    prepared, truth = drawn("cubic_stiffness", 0.02, 11)
    step = step_of(fit_baseline((prepared,), base_model()))
    effect, line = curve_of_rest(step.baseline, "curve")
    assert line.startswith("curve = spline(u, ")
    fitted = add_effect(step, effect)
    assert fitted.at_floor
    form = read_curve(line.partition("=")[2])
    values = [fitted.fit.values[f"curve.{p.name}"].value for p in effect.parameters]
    coefficients = np.insert(values[0] * np.array(values[1:]), form.unit - 1, values[0])
    u = np.linspace(form.low, form.high, 60)
    found, true = form.basis(u) @ coefficients, truth["parameters"]["k3"] * u**3
    line_of = np.column_stack([np.ones_like(u), u])
    off = (found - true) - line_of @ np.linalg.lstsq(line_of, found - true, rcond=None)[0]
    bend = true - line_of @ np.linalg.lstsq(line_of, true, rcond=None)[0]
    assert np.std(off) < 0.02 * np.std(bend)  # the curve holds u^3 exactly; noise leaves a percent
