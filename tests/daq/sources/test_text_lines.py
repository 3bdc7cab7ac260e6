"""Lines as boards print them: which numbers they hold, and what is no line."""

import math

import pytest
from hypothesis import given, strategies as st

from daq.sources.text_lines import LONGEST, LineCutter, header_of, parse_line


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("1,2.5,-3e-2", {"1": 1, "2": 2.5, "3": -0.03}),
        ("1; 2 ;3", {"1": 1, "2": 2, "3": 3}),
        ("12\t-7", {"1": 12, "2": -7}),
        ("  .5   6.", {"1": 0.5, "2": 6}),
        ("x:1.2 y:-3", {"x": 1.2, "y": -3}),
        ("x = 1.2, acc z = 4e3", {"x": 1.2, "acc z": 4000}),
        ("Pos: 512 t: 1033", {"Pos": 512, "t": 1033}),
        ('{"t": 1, "a": {"x": 2}, "v": [3, 4.5], "ok": true}', {"t": 1, "v.1": 3, "v.2": 4.5}),
    ],
)
def test_numbers_of_a_line(text, values):
    line = parse_line(text)
    assert line is not None
    assert line == pytest.approx(values)


def test_what_is_no_number_in_its_place_reads_as_nan():
    line = parse_line("1,nan,3")
    assert line is not None
    assert math.isnan(line["2"])


@pytest.mark.parametrize(
    "text", ["hello", "time,x,y", "{", '{"a": "b"}', "1,2,abc", "$GPGGA,1,2*3A", "", "1,2,,x"]
)
def test_what_is_no_line(text):
    assert parse_line(text) is None


def test_a_header_gives_names():
    assert header_of("time (ms), Position [mm], acc") == ("time (ms)", "Position [mm]", "acc")
    assert header_of("millis adc0 adc1") == ("millis", "adc0", "adc1")
    assert header_of("1,2,3") == ()


def test_the_first_line_may_have_begun_before_and_is_left_out():
    cutter = LineCutter()
    assert cutter.feed(b"34,5\r\n1,2\r\n3,") == ["1,2"]
    assert cutter.feed(b"4\r\n") == ["3,4"]


def test_a_line_that_never_ends_takes_no_memory():
    cutter = LineCutter()
    for _ in range(100):
        cutter.feed(b"7" * 1000)
    assert len(cutter._rest) <= LONGEST
    assert cutter.feed(b"7\n1,2\n") == ["1,2"]


def test_the_end_of_a_line_that_was_thrown_away_is_no_line():
    cutter = LineCutter()
    cutter.feed(b"7" * 5000)
    assert cutter.feed(b"8,9\n" + b"7" * 5000) == []
    assert cutter.feed(b"\n1,2\n") == ["1,2"]


@given(st.lists(st.binary(max_size=40), max_size=30))
def test_any_bytes_are_cut_and_read_without_an_error(parts):
    cutter = LineCutter()
    for part in parts:
        for text in cutter.feed(part):
            line = parse_line(text)
            assert line is None or line
            header_of(text)
