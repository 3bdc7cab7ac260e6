"""The sampling rate of a capture has an error, the larger the less its clocks tell, and is judged by it."""

from collections.abc import Sequence
from dataclasses import replace
from zlib import crc32

import numpy as np
import pytest
from scripted_board import RATE, decay, describe

from daq.clock_check import CLOCK_LIMIT, HOST_SHARE, UNCHECKED_SHARE, checked_rate
from daq.decode import Assembly
from daq.quality import Grade, judge
from firmware_protocol import Clock, Data, End, Frame, Hello, SampleFormat

N, COUNT = 16, 3072
SAMPLES = decay(COUNT, 256)


def stream(n: int = N, late_us: Sequence[float] | None = None) -> list[Data]:
    late = np.zeros(COUNT) if late_us is None else late_us
    return [
        Data(
            first,
            round(1e7 + first / RATE * 1e6 + late[first]),
            0,
            n,
            2,
            SampleFormat.F64,
            SAMPLES[:, first : first + n].T.astype("<f8").tobytes(),
        )
        for first in range(0, COUNT, n)
    ]


def captured(
    messages: Sequence[Data],
    true_rate: float = RATE,
    hold_s: float = 0.0,
    ppm: float | None = None,
    pause_s: float = 0.0,
) -> Assembly:
    """A capture of 12 s that a computer with a true clock received, on a line that holds frames for `hold_s`.

    The board pauses for `pause_s` before sample 1500, and does not count.
    """
    random, made = np.random.default_rng(3), Assembly()
    before = (Hello(1, 1), describe(), *([] if ppm is None else [Clock(ppm)]))
    for sequence, message in enumerate(before):
        made.take(Frame(sequence, 0, message), 0.0)
    for sequence, data in enumerate(messages, len(before)):
        sent = (data.first_index + data.n) / true_rate
        sent += pause_s if data.first_index + data.n > 1500 else 0.0
        sent = np.ceil(sent / hold_s) * hold_s if hold_s else sent
        made.take(Frame(sequence, 0, data), 100.0 + sent + random.uniform(0.0, 1e-3))
    check = crc32(b"".join(d.samples for d in messages))
    made.take(Frame(999, 0, End(COUNT, 0, check)), 200.0)
    made.take_note({"event": "window", "first": 0, "count": COUNT, "trigger": 256})
    return made


def share(made: Assembly) -> float:
    return checked_rate(made).std / RATE


def reasons(made: Assembly) -> str:
    return " ".join(judge(made.recording(), made).reasons)


def test_a_sound_board_on_a_quiet_line_is_ok_within_what_this_computers_clock_is_good_for() -> None:
    made = captured(stream())
    assert judge(made.recording(), made).grade is Grade.OK
    assert share(made) == HOST_SHARE


def test_of_the_stated_error_and_this_computers_the_smaller_counts_and_at_least_their_difference() -> None:
    assert share(captured(stream(), ppm=5000.0)) == HOST_SHARE
    assert share(captured(stream(), ppm=20.0)) < HOST_SHARE
    assert share(captured(stream(), 1.002 * RATE, ppm=20.0)) == pytest.approx(2e-3, rel=0.05)
    assert share(captured(stream(), 1.002 * RATE, ppm=5000.0)) == pytest.approx(2e-3, rel=0.05)


@pytest.mark.parametrize("true", [0.7, 0.94, 0.985, 0.997, 1.004, 1.02, 1.5])
@pytest.mark.parametrize("hold_s", [0.0, 0.1, 0.31, 0.8])
@pytest.mark.parametrize("ppm", [None, 20.0])
def test_a_rate_that_is_off_is_in_the_error_however_the_line_delivers(true, hold_s, ppm) -> None:
    made = captured(stream(), true * RATE, hold_s, ppm)
    assert abs(true - 1) < 2 * share(made)
    if abs(true - 1) > CLOCK_LIMIT:
        assert judge(made.recording(), made).grade is not Grade.OK


def test_a_line_that_holds_back_makes_the_error_larger_not_smaller() -> None:
    shares = [share(captured(stream(), hold_s=hold, ppm=20.0)) for hold in (0.0, 0.31, 0.8, 2.0)]
    assert shares == sorted(shares)
    assert shares[-1] == UNCHECKED_SHARE


@pytest.mark.parametrize("ppm", [None, 20.0])
def test_a_clock_that_nothing_was_held_against_may_be_off_by_a_tenth(ppm: float | None) -> None:
    made = captured(stream(512), 0.8 * RATE, ppm=ppm)  # six frames
    assert share(made) == UNCHECKED_SHARE
    assert judge(made.recording(), made).grade is Grade.USABLE
    assert "could not be checked: samples arrived fewer than 8 times" in reasons(made)


def test_data_longer_than_the_protocol_allows_is_said() -> None:
    assert "each DATA holds 48 samples, 0.188 s; the protocol allows 0.1 s" in reasons(captured(stream(48)))
    assert "the protocol allows" not in reasons(captured(stream(24)))


@pytest.mark.parametrize("ppm", [1e-300, -20.0, 1e-3, 1e6, float("nan"), float("inf"), 5e-324])
def test_a_clock_that_cannot_be_is_not_believed(ppm: float) -> None:
    made = captured(stream(), ppm=ppm)
    assert share(made) == HOST_SHARE
    assert judge(made.recording(), made).grade is Grade.USABLE
    assert "not believed" in reasons(made)


def test_a_clock_of_which_the_board_knows_nothing_is_no_claim() -> None:
    assert reasons(captured(stream(), ppm=0.0)) == ""


@pytest.mark.parametrize("pause_s", [0.018, 0.03])
def test_a_pause_that_the_boards_stamps_hide_is_seen_in_the_arrivals(pause_s: float) -> None:
    made = captured(stream(), pause_s=pause_s)
    assert judge(made.recording(), made).grade is Grade.USABLE
    assert "ms later: the board may have paused" in reasons(made)
    assert share(made) == pytest.approx(pause_s, abs=2e-3)


def test_more_dropped_samples_than_are_missing_are_a_contradiction() -> None:
    messages = stream()
    made = captured([*messages[:40], replace(messages[40], dropped_before=1000), *messages[41:]])
    assert (
        "1000 samples were dropped before sample 640, but only 0 are missing there" in made.contradictions[0]
    )
    assert judge(made.recording(), made).grade is Grade.REJECT
