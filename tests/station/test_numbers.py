"""Numbers and units: the same value reads the same in a terminal, on the page and in the report."""

import pytest

from identify.comparison.discrepancy_text import DiscrepancyText
from identify.estimate import Estimate
from identify.formatting import SPACE, odds_words, quantity, three_figures, with_error
from station.story.engineering_values import UNKNOWN, Weighing
from station.text.numbers import (
    amplitude_words,
    energy_scale,
    noise_words,
    scale,
    scale_as_recorded,
    typeset,
    with_unit,
)


def test_noise_is_shown_in_the_unit_that_its_size_asks_for():
    assert noise_words("displacement", 3e-6, "m") == "displacement 3 µm"
    assert noise_words("displacement", 2e-3, "rad") == "displacement 2 mrad"
    assert noise_words("displacement", 0.997, "count") == "displacement 1 count"
    assert noise_words("acceleration", 0.5, "m") == "acceleration 0.5 m/s²"


def test_an_amplitude_has_no_sign_and_is_in_mm():
    assert amplitude_words(-0.025, "m") == "25.0 mm"
    assert amplitude_words(None, "m") == "-"


def test_what_is_not_known_is_said_so():
    assert with_error(None, None) == "unknown"
    assert with_error(2.0, None) == "2 (error unknown)"
    assert three_figures(None) == "-"


def test_a_value_has_the_digits_that_its_error_allows():
    found = Estimate(13115.04, 2.08, "N/m")
    assert with_unit(found).replace(SPACE, " ") == "13115.0 ± 2.1 N/m"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0123456, "0.0123"),
        (132.4, "132"),
        (1234567.0, "1.23 × 10⁶"),
        (1.2e-5, "1.20 × 10⁻⁵"),
        (0.0, "0.00"),
    ],
)
def test_three_figures_of_what_is_very_large_or_small_take_a_power_of_ten_on_a_page(value, text):
    assert three_figures(value) == text


def test_a_channel_is_shown_in_a_unit_that_suits_it():
    assert scale("displacement", "m") == (1e3, "mm")
    assert scale("displacement", "rad", fine=True) == (1e3, "mrad")
    assert scale("acceleration", "m") == (1.0, "m/s^2")


def test_a_force_keeps_the_unit_in_which_it_was_recorded():
    assert scale_as_recorded("force", "N") == (1.0, "N")
    assert scale_as_recorded("acceleration", "m/s^2") == (1.0, "m/s^2")
    assert scale_as_recorded("displacement", "m") == (1e3, "mm")


def test_an_energy_is_in_thousandths_of_a_joule_and_of_the_whole_mass_where_it_is_known():
    assert energy_scale(DiscrepancyText("m", 2.0)) == (2e3, "mJ")
    assert energy_scale(DiscrepancyText("m", None)) == (1e3, "mJ/kg")
    assert energy_scale(DiscrepancyText("rad", None)) == (1.0, "rad^2/s^2")


def test_powers_and_greek_letters_are_typeset():
    assert typeset("3 um at 2 m/s^2, 1 +- 0.1") == "3 µm at 2 m/s², 1 ± 0.1"
    assert typeset("mu_0") == "μ₀"
    assert typeset("k3") == "k3"


def test_no_zero_has_a_sign_and_evidence_is_told_as_odds():
    assert with_error(-0.004, 1.2).replace(SPACE, " ") == "0.0 ± 1.2"
    assert [odds_words(nats) for nats in (0.0, 2.3, 9.2)] == ["1 to 1", "10 to 1", "10⁴ to 1"]
    assert odds_words(40.2) == "10⁵ to 1 or more"


def test_an_error_that_leaves_no_digit_does_not_hide_the_value():
    said = quantity(Estimate(4.54, 4.8e6, "rad/s")).replace(SPACE, " ")
    assert said == "4.54 rad/s (error 4.80 × 10⁶)"
    assert with_error(0.0, 1.2).replace(SPACE, " ") == "0.0 ± 1.2"


def test_what_moves_through_an_angle_has_a_torque_and_an_inertia():
    assert Weighing(unit="rad").worded() == "torque per unit inertia"
    assert Weighing(unit="rad").worded("friction force per unit mass") == "friction torque per unit inertia"
    assert Weighing(2.0, unit="rad").worded("stiffness, per unit mass") == "stiffness"
    assert UNKNOWN.worded() == "force per unit mass"


def test_a_force_is_in_newtons_only_where_the_displacement_is_a_length():
    assert Weighing(2.0).force_scale == (2.0, "N")
    assert Weighing(2.0, unit="rad").force_scale == (2.0, "N m")
    assert Weighing(2.0, unit="V").force_scale == (2.0, "kg V/s^2")
    assert UNKNOWN.force_scale == (1.0, "m/s^2")


@pytest.mark.parametrize(
    ("length", "per_mass", "unit"),
    [
        ("m", "1/s", "N s/m"),
        ("m", "1/m", "kg/m"),
        ("m", "s/m^2", "kg s/m^2"),
        ("m", "1/(m^4 s^2)", "N/m^5"),
        ("m", "1/(m^2 s)", "N s/m^3"),
        ("m", "reading/s", "kg reading/s"),
        ("rad", "1/s^2", "N m/rad"),
        ("rad", "1/(rad^2 s^2)", "N m/rad^3"),
        ("rad", "1/rad", "N m s^2/rad^2"),
        ("rad", "s/rad^2", "N m s^3/rad^3"),
    ],
)
def test_a_strength_times_the_mass_has_a_unit_that_an_engineer_writes(length, per_mass, unit):
    assert Weighing(2.0, unit=length).strength(Estimate(1.5, 0.1, per_mass)).unit == unit


def test_a_value_that_is_exact_stands_alone():
    assert with_error(0.0184, 0.0) == "0.0184"
    assert with_unit(Estimate(0.0184, 0.0, "m")).replace(SPACE, " ") == "0.0184 m"
