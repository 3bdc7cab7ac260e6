"""Headers and units in the words of several languages."""

import math

import pytest

from daq.importing.columns import meaning, split_unit
from daq.importing.units import parse_scaled_unit, parse_unit

HEADERS = [
    ("time_s", "time", "s", 1.0),
    ("t (ms)", "time", "s", 1e-3),
    ("Zeit t / s", "time", "s", 1.0),
    ("Время, с", "time", "s", 1.0),
    ("时间(s)", "time", "s", 1.0),
    ("displacement_m", "displacement", "m", 1.0),
    ("disp_mm", "displacement", "m", 1e-3),
    ("Weg &b_A1 / rad", "displacement", "rad", 1.0),
    ("Position (mm)", "displacement", "m", 1e-3),
    ("Déplacement [µm]", "displacement", "m", 1e-6),
    ("Auslenkung in mm", "displacement", "m", 1e-3),
    ("Posição (cm)", "displacement", "m", 1e-2),
    ("Przemieszczenie [mm]", "displacement", "m", 1e-3),
    ("Смещение, мм", "displacement", "m", 1e-3),
    ("変位[mm]", "displacement", "m", 1e-3),
    ("变位 (mm)", "displacement", "m", 1e-3),
    ("변위 (mm)", "displacement", "m", 1e-3),
    ("Winkel in °", "displacement", "rad", math.pi / 180),
    ("Vinkel [grader]", "displacement", None, None),
    ("position_inch", "displacement", "m", 0.0254),
    ("Velocity (mm/s)", "velocity", "m/s", 1e-3),
    ("Vitesse [m.s-1]", "velocity", "m/s", 1.0),
    ("velocidad m/s", "velocity", "m/s", 1.0),
    ("zeitliche Ableitung w_1 / rad/s", "velocity", "rad/s", 1.0),
    ("Gyro x (deg/s)", "velocity", "rad/s", math.pi / 180),
    ("AngVel/rad/s", "velocity", "rad/s", 1.0),
    ("速度 m/s", "velocity", "m/s", 1.0),
    ("acceleration_m_s2", "acceleration", "m/s^2", 1.0),
    ("acc [g]", "acceleration", "m/s^2", 9.80665),
    ("a/g", "acceleration", "m/s^2", 9.80665),
    ("accel_mps2", "acceleration", "m/s^2", 1.0),
    ("Beschleunigung in m/s²", "acceleration", "m/s^2", 1.0),
    ("加速度(m/s^2)", "acceleration", "m/s^2", 1.0),
    ("Ускорение, м/с²", "acceleration", "m/s^2", 1.0),
    ("Acceleration x (m/s**2)", "acceleration", "m/s^2", 1.0),
    ("Kraft F [kN]", "force", "N", 1e3),
    ("Torque (Nm)", "force", "N m", 1.0),
]


@pytest.mark.parametrize(("header", "quantity", "si", "scale"), HEADERS)
def test_a_header_gives_quantity_and_unit(
    header: str, quantity: str, si: str | None, scale: float | None
) -> None:
    found = meaning(header)
    assert found.quantity == quantity
    assert (found.unit.si if found.unit else None) == si
    if found.unit is not None and scale is not None:
        assert math.isclose(found.unit.scale, scale, rel_tol=1e-12)


@pytest.mark.parametrize(
    "header",
    ["Frequenz f / Hz", "FFT f_3 / rad", "Spannung U_B1 / V", "Temperature (K)", "position error (mm)"],
)
def test_a_header_of_something_else_is_no_motion(header: str) -> None:
    assert meaning(header).quantity is None


@pytest.mark.parametrize("header", ["x", "phi", "y", "theta"])
def test_a_mere_letter_is_the_weakest_hint(header: str) -> None:
    assert meaning(header).quantity == "displacement"
    assert meaning(header).strength == 1


def test_a_unit_outweighs_a_word_that_contradicts_it() -> None:
    assert meaning("Position (mm/s)").quantity == "velocity"


def test_a_unit_row_serves_where_the_header_has_none() -> None:
    found = meaning("Kanal 3", "[mm]")
    assert (found.quantity, found.strength) == ("displacement", 2)


def test_a_name_keeps_what_is_not_its_unit() -> None:
    assert split_unit("Weg &b_A1 / rad")[:2] == ("Weg &b_A1", "rad")
    assert split_unit("count A")[:2] == ("count A", "")
    assert split_unit("I [A]")[:2] == ("I", "A")


@pytest.mark.parametrize("text", ["furlong", "", "m" * 50, "1", "mm mm"])
def test_an_unknown_unit_is_none(text: str) -> None:
    assert parse_unit(text) is None


def test_an_option_may_give_a_sensors_scale() -> None:
    unit = parse_scaled_unit("0.0025 m")
    assert unit is not None
    assert (unit.scale, unit.si, unit.quantity) == (0.0025, "m", "displacement")


@pytest.mark.parametrize("text", ["0 m", "nan m", "1e999 m", "m 2", "-", "5"])
def test_a_scale_that_is_none_is_refused(text: str) -> None:
    assert parse_scaled_unit(text) is None


@pytest.mark.parametrize("letter", ["θ", "φ", "theta", "phi", "psi"])
def test_a_greek_letter_is_an_angle_as_its_name_is(letter: str) -> None:
    assert meaning(letter).angular
    assert meaning(letter).quantity == "displacement"
