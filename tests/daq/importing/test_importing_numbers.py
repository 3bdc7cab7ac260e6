"""Numbers as people write them."""

import math

import numpy as np
import pytest

from daq.importing.numbers import parse_clock, parse_column, parse_number


@pytest.mark.parametrize(
    ("text", "decimal", "number"),
    [
        ("1.5", ".", 1.5),
        (" -1,5 ", ",", -1.5),
        ("1.5D+02", ".", 150.0),
        ("−3", ".", -3.0),
        ("+.5e-1", ".", 0.05),
        ("7.", ".", 7.0),
        ('"2.5"', ".", 2.5),
    ],
)
def test_a_number_is_read(text: str, decimal: str, number: float) -> None:
    assert parse_number(text, decimal) == number


@pytest.mark.parametrize("text", ["", "NaN", "n/a", "-", "#DIV/0!", "inf", "null"])
def test_an_empty_cell_is_not_a_number(text: str) -> None:
    number = parse_number(text)
    assert number is not None
    assert math.isnan(number)


@pytest.mark.parametrize(
    "text", ["abc", "1_000", "0x10", "1.2.3", "1,500", "1 2", "9" * 70, "12 mm", "1,234.5", "12 345"]
)
def test_anything_else_is_refused(text: str) -> None:
    assert parse_number(text) is None


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        ("12:34:56.5", 45296.5),
        ("00:01,5", 1.5),
        ("1970-01-02T00:00:01.25Z", 1.25),
        ("02.01.1970 00:00:01,25", 1.25),
        ("01/02/1970 00:00:01", 1.0),
    ],
)
def test_a_time_of_day_is_read_in_seconds(text: str, seconds: float) -> None:
    assert parse_clock(text) == seconds


@pytest.mark.parametrize("text", ["12", "1970-01.02 00:00:00", "1970 00:00:00", "a:b:c", ":"])
def test_what_is_no_clock_is_refused(text: str) -> None:
    assert parse_clock(text) is None


def test_a_column_names_its_first_bad_cell() -> None:
    found = parse_column(["1.5", "", "oops", "2"], ".")
    assert found.bad == (2, "oops")
    np.testing.assert_array_equal(found.values, [1.5, np.nan, np.nan, 2.0])
