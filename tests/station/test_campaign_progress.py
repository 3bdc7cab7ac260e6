"""How far a campaign is: plain lines where nobody watches, one line written over in a terminal."""

import io

import pytest

from station.text.campaign_progress import CampaignProgress, duration


class Terminal(io.StringIO):
    def isatty(self):
        return True


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


def watched(stream, total=100):
    clock = Clock()
    return CampaignProgress(total, stream, clock), clock


def test_the_line_says_how_many_how_fast_how_long_and_who_failed():
    watch, clock = watched(io.StringIO())
    for _ in range(20):
        watch.kept("k")
    for _ in range(40):
        watch.done("d")
    clock.now = 10.0
    watch.failed("torn", "no metadata")
    assert watch.line() == "61/100 sessions, 20 kept from before, 4/s, 10 s left, 1 failed"


def test_a_file_gets_plain_lines_not_more_than_one_in_ten_seconds():
    stream = io.StringIO()
    watch, clock = watched(stream)
    for second in range(35):
        clock.now = float(second)
        watch.done("d")
    lines = stream.getvalue().splitlines()
    assert len(lines) == 3
    assert "\r" not in stream.getvalue()
    assert lines[0].startswith("11/100 sessions")


def test_a_terminal_gets_one_line_that_fits_and_a_failure_its_own():
    stream = Terminal()
    watch, clock = watched(stream)
    for tenth in range(50):
        clock.now = tenth / 10.0
        watch.done("d")
    watch.failed("torn\x1b[2J", "no metadata")
    watch.end()
    parts = stream.getvalue().split("\r")
    assert max(len(part.rstrip("\n")) for part in parts) <= 80
    assert "\x1b" not in stream.getvalue()
    assert stream.getvalue().count("\n") == 2


@pytest.mark.parametrize(
    ("seconds", "text"), [(46.2, "46 s"), (720, "12 min"), (12240, "3.4 h"), (0.2, "0 s")]
)
def test_a_time_is_said_as_people_do(seconds, text):
    assert duration(seconds) == text
