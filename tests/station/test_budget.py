"""The whole error of a value: what the scale of a sensor and the mass add to that of the readings."""

import math

import pytest

from identify.estimate import Estimate
from identify.units import power_in
from station.story.engineering_values import EngineeringValue, budget

FRICTION = EngineeringValue("friction force", Estimate(2.0, 0.05, "N"), Estimate(0.1, 0.001, "m/s^2"))
STIFFNESS = EngineeringValue("stiffness K", Estimate(12000.0, 100.0, "N/m"), Estimate(600.0, 0.6, "1/s^2"))


@pytest.mark.parametrize(
    ("unit", "power"),
    [
        ("1/s^2", 0),
        ("m/s^2", 1),
        ("1/m", -1),
        ("s/m^2", -2),
        ("1/(m^2 s^2)", -2),
        ("mm", 0),
        ("1", 0),
        ("Hz", 0),
    ],
)
def test_the_power_of_a_length_is_read_from_the_unit(unit, power):
    assert power_in(unit, {"m": 1}) == power


def test_angles_are_a_length_of_their_own():
    assert power_in("rad/s^2", {"rad": 1}) == 1
    assert power_in("rad/s^2", {"m": 1}) == 0


def test_a_force_takes_the_error_of_the_scale_and_of_the_mass_and_a_stiffness_that_of_the_mass_alone():
    friction = budget(FRICTION, 0.02, 0.01)
    assert (friction.readings, friction.calibration, friction.mass) == pytest.approx((0.02, 0.04, 0.02))
    assert friction.total == pytest.approx(math.sqrt(0.02**2 + 0.04**2 + 0.02**2))
    stiffness = budget(STIFFNESS, 0.02, 0.01)
    assert (stiffness.readings, stiffness.calibration, stiffness.mass) == pytest.approx((12.0, 0.0, 120.0))


def test_what_was_not_stated_leaves_the_total_undetermined_only_where_it_enters():
    assert budget(FRICTION, None, 0.01).total is None
    assert budget(STIFFNESS, None, None).total is None
    assert budget(STIFFNESS, None, 0.01).total == pytest.approx(math.hypot(12.0, 120.0))
    frequency = EngineeringValue("natural frequency", Estimate(3.9, 0.001, "Hz"))
    assert budget(frequency, None, None).total == pytest.approx(0.001)
