"""Averaged signatures against their closed forms."""

import numpy as np
import pytest

from identify.effects.compiled import effect_function
from identify.effects.effect import Parameter
from identify.effects.force_effect import ForceEffect
from identify.effects.library import LIBRARY, find_effect
from identify.model.equivalent_linearisation import average

W = 24.78
A = np.array([0.004, 0.012, 0.023])

CLOSED = [
    ("linear_stiffness", {"k": 3.0}, 0 * A, 3.0 + 0 * A),
    ("viscous_damping", {"mu_1": 0.27}, 0.27 + 0 * A, 0 * A),
    ("coulomb_friction", {"mu_0": 0.13}, 4 * 0.13 / (np.pi * W * A), 0 * A),
    ("quadratic_damping", {"c2": 0.7}, 8 * 0.7 * W * A / (3 * np.pi), 0 * A),
    ("cubic_damping", {"c3": 1.3}, 3 * 1.3 * W**2 * A**2 / 4, 0 * A),
    ("position_dependent_damping", {"c12": 900.0}, 900.0 * A**2 / 4, 0 * A),
    ("position_dependent_friction", {"slope": 2.0}, 2 * 2.0 / (np.pi * W) + 0 * A, 0 * A),
    ("cubic_stiffness", {"k3": 5e4}, 0 * A, 3 * 5e4 * A**2 / 4),
    ("quintic_stiffness", {"k5": 5e7}, 0 * A, 5 * 5e7 * A**4 / 8),
    ("quadratic_stiffness", {"k2": 900.0}, 0 * A, -5 * 900.0**2 * A**2 / (6 * W**2)),
    ("signed_quadratic_stiffness", {"k2a": 700.0}, 0 * A, 8 * 700.0 * A / (3 * np.pi)),
    (
        "maxwell_element",
        {"k1": 20.0, "tau": 0.03},
        20.0 * 0.03 / (1 + (W * 0.03) ** 2) + 0 * A,
        20.0 * (W * 0.03) ** 2 / (1 + (W * 0.03) ** 2) + 0 * A,
    ),
]


@pytest.mark.parametrize(("name", "parameters", "damping", "stiffening"), CLOSED, ids=[c[0] for c in CLOSED])
def test_signature_is_that_of_the_closed_form(name, parameters, damping, stiffening):
    found = average(find_effect(name), parameters, W, A)
    assert found.settled
    # 512 points a cycle leave 1e-5 of a force that jumps or has a corner, and nothing of a smooth one.
    np.testing.assert_allclose(found.damping, damping, rtol=2e-4, atol=1e-6)
    np.testing.assert_allclose(found.stiffening, stiffening, rtol=2e-4, atol=1e-5)


def test_an_end_stop_does_nothing_below_its_gap_and_stiffens_above():
    """Above the gap dw2 = (2 ks/pi)(acos r - r sqrt(1 - r^2)), r = gap/A, with stops on both sides."""
    found = average(find_effect("end_stop"), {"ks": 80.0, "gap": 0.010, "side": 0.0}, W, A)
    r = 0.010 / A[1:]
    closed = 2 * 80.0 / np.pi * (np.arccos(r) - r * np.sqrt(1 - r**2))
    assert found.stiffening[0] == 0.0
    np.testing.assert_allclose(found.stiffening[1:], closed, rtol=1e-3)  # the corner falls between points


def test_a_stop_that_takes_energy_stiffens_as_an_elastic_one_and_damps_besides():
    """c_eq = 4 ks loss/(pi A^2) int_0^acos(gap/A) (A cos x - gap) A^2 sin^2 x dx, with stops on both sides."""
    found = average(
        find_effect("impact_with_loss"), {"ks": 80.0, "gap": 0.010, "side": 0.0, "loss": 1.5}, W, A
    )
    a, x = A[1:], np.arccos(0.010 / A[1:])
    inside = a**3 * np.sin(x) ** 3 / 3 - 0.010 * a**2 * (x / 2 - np.sin(2 * x) / 4)
    assert found.damping[0] == 0.0
    np.testing.assert_allclose(found.damping[1:], 4 * 80.0 * 1.5 / (np.pi * a**2) * inside, rtol=1e-3)
    r = 0.010 / a
    closed = 2 * 80.0 / np.pi * (np.arccos(r) - r * np.sqrt(1 - r**2))
    np.testing.assert_allclose(found.stiffening[1:], closed, rtol=1e-3)


@pytest.mark.parametrize("over", [3e-4, 4e-3, 0.05])
def test_presliding_friction_loses_the_area_of_dahls_loop(over):
    """z = ud (1 - c exp(-(u + A)/ud)) on the way up, and minus that on the way down: c = 2/(1 + exp(-2 A/ud))."""
    found = average(find_effect("dahl_friction"), {"kd": 30.0, "ud": over}, W, A)
    c = 2.0 / (1.0 + np.exp(-2.0 * A / over))
    area = 2.0 * 30.0 * over * (2.0 * A - c * over * (1.0 - np.exp(-2.0 * A / over)))
    assert found.settled
    np.testing.assert_allclose(found.damping, area / (np.pi * W * A**2), rtol=1e-3)


def test_freeplay_softens_at_small_amplitude():
    found = average(find_effect("freeplay"), {"kf": 40.0, "gap": 0.006}, W, A)
    r = np.minimum(0.006 / A, 1.0)
    closed = -40.0 * 2 / np.pi * (np.arcsin(r) + r * np.sqrt(1 - r**2))
    np.testing.assert_allclose(found.stiffening, closed, rtol=1e-3)


def test_a_spring_stiffer_on_one_side_shifts_the_frequency_alike_at_every_amplitude():
    found = average(find_effect("bilinear_stiffness"), {"kb": 2.0}, W, A)
    # Exact: half a period at sqrt(w^2 + kb/2), half at sqrt(w^2 - kb/2): slower by a share of order (kb/w^2)^2.
    harder, softer = np.sqrt(W**2 + 1.0), np.sqrt(W**2 - 1.0)
    exact = (2 * harder * softer / (harder + softer)) ** 2 - W**2
    np.testing.assert_allclose(found.stiffening, exact, atol=1e-3 * 2.0)
    assert np.ptp(found.stiffening) < 1e-3 * 2.0


def test_hysteresis_loses_most_where_it_yields_and_softens_beyond():
    """A joint that yields takes at most as much as dry friction of kh uy, and none of its stiffness is left far out."""
    amplitudes = 0.004 * np.array([0.05, 1.0, 2.0, 4.0, 60.0])
    found = average(find_effect("hysteresis"), {"kh": 30.0, "uy": 0.004}, W, amplitudes)
    assert found.settled
    assert np.argmax(found.damping) == 2
    assert found.stiffening[0] == pytest.approx(30.0, rel=0.05)
    assert np.all(np.diff(found.stiffening) < 0)
    dry = 4 * 30.0 * 0.004 / (np.pi * W * amplitudes[-1])
    assert found.damping[-1] == pytest.approx(dry, rel=0.05)


def test_a_second_mass_well_above_the_frequency_adds_its_inertia():
    """The force ratio (y'') of a mass that follows: -ratio w^2 w2^2/(w2^2 - w^2) on w^2, undamped."""
    found = average(find_effect("second_mass"), {"ratio": 0.01, "w2": 90.0, "zeta": 1e-4}, W, A)
    closed = -0.01 * W**2 * 90.0**2 / (90.0**2 - W**2)
    assert found.settled
    np.testing.assert_allclose(found.stiffening, closed, rtol=1e-3)


def test_a_time_varying_stiffness_is_that_of_the_moment():
    found = average(
        find_effect("time_varying_stiffness"), {"rate": 0.01, "linear_stiffness.k": W**2}, W, A, time=2.0
    )
    np.testing.assert_allclose(found.stiffening, 0.02 * W**2, rtol=1e-6)


def test_a_settling_stiffness_is_that_of_the_moment():
    values = {"r": 0.03, "tau": 1.5, "linear_stiffness.k": W**2}
    found = average(find_effect("settling_stiffness"), values, W, A, time=2.0)
    np.testing.assert_allclose(found.stiffening, 0.03 * (1.0 - np.exp(-2.0 / 1.5)) * W**2, rtol=1e-6)


@effect_function
def _magnet(t, u, v, z, p):
    return p[0] * u / (1.0 + (u / p[1]) ** 2)


def test_an_effect_of_the_users_own_has_a_signature_too():
    """For u/(1 + (u/b)^2): dw2 = 2 a (b/A)^2 (1 - b/sqrt(b^2 + A^2))."""
    magnet = ForceEffect(
        name="magnet",
        title="magnet",
        equation="a u/(1 + (u/b)^2)",
        parameters=(Parameter("a", "1/s^2", "pull"), Parameter("b", "m", "width")),
        symptom="softer at large amplitude",
        confirming_test="take the magnet away",
        force=_magnet,
    )
    found = average(magnet, {"a": 5.0, "b": 0.007}, W, A)
    closed = 2 * 5.0 * (0.007 / A) ** 2 * (1 - 0.007 / np.sqrt(0.007**2 + A**2))
    np.testing.assert_allclose(found.stiffening, closed, rtol=1e-6)
    np.testing.assert_allclose(found.damping, 0.0, atol=1e-9)


def test_a_sensors_fault_has_none_and_says_so():
    with pytest.raises(ValueError, match="fault of a sensor"):
        average(find_effect("clipping"), {"limit": 1.0, "center": 0.0}, W, A)


def test_a_missing_parameter_is_named():
    with pytest.raises(ValueError, match="needs a value of uy"):
        average(find_effect("hysteresis"), {"kh": 1.0}, W, A)


def test_every_force_of_the_library_has_a_signature():
    for effect in LIBRARY:
        if effect.kind == "physics":
            values = dict.fromkeys((p.name for p in effect.parameters), 0.5) | dict.fromkeys(
                effect.shared_parameters, W**2
            )
            found = average(effect, values, W, A)
            assert np.isfinite(found.damping).all(), effect.name
            assert np.isfinite(found.stiffening).all(), effect.name


@pytest.mark.parametrize(
    "effect", [e for e in LIBRARY if getattr(e, "proportional", False)], ids=lambda e: e.name
)
def test_a_proportional_force_changes_frequency_and_loss_alike_at_all_amplitudes(effect):
    inner = {p.name: value for p, value in zip(effect.parameters, (1.0, 0.7 * W, 0.05), strict=False)}
    found = average(effect, inner, W, A)
    assert np.ptp(found.damping) < 1e-4 * np.abs(found.damping).max()
    assert (
        np.ptp(found.stiffening)
        < 1e-4 * W * np.abs(found.damping).max() + 1e-4 * np.abs(found.stiffening).max()
    )
