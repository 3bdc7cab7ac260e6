"""A wrong value never passes as OK: the messages of a board that contradicts itself, put together and judged."""

from dataclasses import replace
from zlib import crc32

import numpy as np
import pytest
from scripted_board import RATE, decay, describe

from daq.decode import Assembly
from daq.quality import Grade, Verdict, judge
from firmware_protocol import Data, Describe, End, Event, EventKind, Frame, Hello, Log, SampleFormat

N, COUNT = 16, 2304
SAMPLES = decay(COUNT, 256)


def data(first: int, n: int = N, samples: np.ndarray = SAMPLES, late_us: float = 0.0) -> Data:
    part = samples[:, first : first + n].T.astype("<f8").tobytes()
    return Data(first, round(1e7 + first / RATE * 1e6 + late_us), 0, n, 2, SampleFormat.F64, part)


STREAM = [data(first) for first in range(0, COUNT, N)]
END = End(COUNT, 0, crc32(data(0, COUNT).samples))


def taken(*messages: object, window: tuple[int, int] = (0, COUNT)) -> Assembly:
    made = Assembly()
    for sequence, message in enumerate((Hello(1, 1), describe(), *messages)):
        frame = message if isinstance(message, Frame) else Frame(sequence, 0, message)  # type: ignore[arg-type]
        made.take(frame, 0.0)
    made.take_note({"event": "window", "first": window[0], "count": window[1], "trigger": window[0] + 256})
    return made


def verdict(made: Assembly) -> Verdict:
    return judge(made.recording(), made, check_clock=False)


def test_a_sound_board_is_ok_and_its_checksum_is_told() -> None:
    found = verdict(taken(*STREAM, END))
    assert (found.grade, found.reasons) == (Grade.OK, ())
    assert found.remarks == ("the board's checksum of all its samples agrees",)


def test_of_two_copies_the_first_stays_and_the_difference_is_listed() -> None:
    wrong = data(160, 48, SAMPLES + 1e-3)
    made = taken(*(d for d in STREAM if d.first_index != 176), END, wrong)
    kept = made.recording().samples
    assert np.array_equal(kept[:, :176], SAMPLES[:, :176])
    assert np.array_equal(kept[:, 192:], SAMPLES[:, 192:])
    assert np.array_equal(kept[:, 176:192], SAMPLES[:, 176:192] + 1e-3)
    assert made.samples.differing == [(160, 32)]
    found = verdict(made)
    assert found.grade is Grade.REJECT
    assert any("32 samples twice with other values, from sample 160" in reason for reason in found.reasons)
    assert any("checksum of all samples does not agree" in reason for reason in found.reasons)


def test_a_checksum_that_agrees_with_the_first_copies_leaves_them_usable() -> None:
    doubled = Frame(0, 0, data(160, 16, SAMPLES + 1e-3))  # an older frame's number: late, not gone back
    found = verdict(taken(*STREAM, doubled, END))
    assert found.grade is Grade.USABLE
    assert "its checksum agrees with them" in found.reasons[0]


def test_the_checksum_is_that_of_the_samples_returned(tmp_path: object) -> None:
    rng = np.random.default_rng(3)
    for _ in range(30):
        made = taken()
        for _ in range(40):
            first, n = int(rng.integers(0, 320)), int(rng.integers(1, 60))
            made.take(Frame(0, 0, data(first, n, SAMPLES + int(rng.integers(0, 2)))), 0.0)
        made.take(Frame(0, 0, END), 0.0)
        made.window = None
        recording = made.recording()
        kept = recording.samples[:, recording.valid].T.astype("<f8").tobytes()
        assert crc32(kept) == made.samples.checksum()
        assert int(recording.valid.sum()) == made.samples.received


@pytest.mark.parametrize("lost", [0, 32, 2288])
def test_what_the_checksum_cannot_be_made_of_makes_a_recording_usable_at_best(lost: int) -> None:
    messages = [d for d in STREAM if d.first_index != lost]
    found = verdict(taken(*messages, END, window=(64, 2200)))
    assert found.grade is Grade.USABLE
    assert "checksum could not be checked: 16 samples that it covers are lost" in " ".join(found.reasons)


def test_a_wrong_value_in_front_of_the_recording_is_no_excuse() -> None:
    messages = [data(0, 16, SAMPLES + 1), *STREAM[1:]]
    assert verdict(taken(*messages, END, window=(64, 2200))).grade is Grade.REJECT


@pytest.mark.parametrize(
    ("end", "why"),
    [
        (replace(END, total_samples=1 << 63), "END says 9223372036854775808 samples"),
        (replace(END, total_samples=COUNT - 1), "but sample 2303 had come"),
        (replace(END, total_dropped=5), "but 2304 came"),
        (replace(END, checksum=END.checksum ^ 1), "checksum of all samples does not agree"),
        (replace(END, total_samples=COUNT + 64, total_dropped=0), "could not be checked"),
    ],
)
def test_an_end_that_contradicts_is_a_reject(end: End, why: str) -> None:
    found = verdict(taken(*STREAM, end))
    assert why in " ".join(found.reasons)
    assert found.grade is (Grade.USABLE if "could not" in why else Grade.REJECT)


def test_samples_counted_as_dropped_by_data_and_not_by_end_are_a_reject() -> None:
    messages = [*STREAM[:10], replace(STREAM[11], dropped_before=16), *STREAM[12:]]
    assert "DATA counted 16 as dropped" in " ".join(verdict(taken(*messages, END)).reasons)


def test_two_ends_that_differ_are_a_reject() -> None:
    found = verdict(taken(*STREAM, END, replace(END, checksum=1)))
    assert "END twice" in found.reasons[0]


@pytest.mark.parametrize(
    ("late_us", "grade"),
    [
        (30_000, Grade.REJECT),
        (-3e6, Grade.REJECT),
        (6000, Grade.REJECT),
        (1500, Grade.USABLE),
        (100, Grade.OK),
    ],
)
def test_a_step_of_the_boards_clock_is_judged_by_its_share_of_a_second(late_us: float, grade: Grade) -> None:
    """More than 5 ms within a second is more than 0.5 % of the rate, more than 0.25 ms more than 0.025 %."""
    messages = [data(first, late_us=late_us if first >= 800 else 0.0) for first in range(0, COUNT, N)]
    found = verdict(taken(*messages, END))
    assert found.grade is grade
    assert grade is Grade.OK or "sample index differ by" in found.reasons[0]


def test_a_step_in_the_last_frame_of_the_recording_is_seen() -> None:
    messages = [data(first, late_us=30_000 if first >= 1600 else 0.0) for first in range(0, COUNT, N)]
    assert verdict(taken(*messages, END, window=(64, 1530))).grade is Grade.REJECT
    assert verdict(taken(*messages, END, window=(64, 1500))).grade is Grade.USABLE


@pytest.mark.parametrize(("late_us", "grade"), [(4000, Grade.USABLE), (20_000, Grade.REJECT)])
def test_a_clock_that_drifts_against_the_index_is_not_ok(late_us: float, grade: Grade) -> None:
    """Half a wave in 9 s: at its steepest 0.35 of its height in a second."""
    messages = [data(f, late_us=late_us * np.sin(f / COUNT * np.pi)) for f in range(0, COUNT, N)]
    assert verdict(taken(*messages, END)).grade is grade


def test_a_clock_that_stands_still_can_vouch_for_nothing() -> None:
    found = verdict(taken(*(replace(d, board_time_us=7) for d in STREAM), END))
    assert found.grade is Grade.USABLE
    assert "clock stands still" in found.reasons[0]


def test_a_board_of_200_ppm_and_a_wrong_stamp_of_a_microsecond_are_no_step() -> None:
    messages = [data(f, late_us=200e-6 * f / RATE * 1e6 + f // N % 2) for f in range(0, COUNT, N)]
    assert verdict(taken(*messages, END)).grade is Grade.OK


def test_a_second_stream_is_kept_out_and_said() -> None:
    doubled = tuple(replace(c, scale=2.0 * c.scale) for c in describe().channels)
    other = [Frame(9, 1, replace(describe(), channels=doubled)), Frame(9, 1, replace(END, checksum=5))]
    other += [Frame(9, 1, data(f, samples=SAMPLES + 1)) for f in range(0, COUNT, N)]
    made = taken(*(m for pair in zip(STREAM, other[2:], strict=True) for m in pair), *other[:2], END)
    assert np.array_equal(made.recording().samples, SAMPLES)
    assert verdict(made).grade is Grade.OK
    assert made.recording().notes == ("the board also sends stream 1; only stream 0 was recorded",)


def test_other_numbers_than_described_are_a_contradiction() -> None:
    made = taken(replace(data(0), format=SampleFormat.F32, samples=bytes(16 * 2 * 4)))
    assert "samples in F32, but F64 was described" in made.contradictions[0]


def test_other_channels_after_start_are_a_contradiction() -> None:
    made = taken()
    made.take_note({"event": "start"})
    made.take(Frame(9, 0, replace(describe(), channels=describe().channels[:1])), 0.0)
    assert "other channels" in made.contradictions[0]


def test_channels_of_one_name_are_told_apart() -> None:
    one = describe().channels[0]
    made = taken(Describe(SampleFormat.F64, (one, one, replace(one, name="x 2"))))
    assert [channel.name for channel in made.channels] == ["x", "x 2", "x 2 2"]


def test_a_unit_that_is_not_si_is_told() -> None:
    channels = (replace(describe().channels[0], unit="mm"), describe().channels[1])
    found = verdict(taken(Describe(SampleFormat.F64, channels), *STREAM, END))
    assert found.grade is Grade.USABLE
    assert "in 'mm' and not in m or rad" in found.reasons[0]


def test_texts_of_a_board_stay_in_one_line() -> None:
    made = taken(Log("good\nverdict: OK\x1b[2J"), Event(EventKind.SENSOR_FAULT, 3, 1, text="a\r\n\u202eb"))
    assert made.notes == [
        "the board said: good\N{REPLACEMENT CHARACTER}verdict: OK\N{REPLACEMENT CHARACTER}[2J"
    ]
    assert made.events[0].text == "a" + 3 * "\N{REPLACEMENT CHARACTER}" + "b"


def test_a_log_of_many_channels_asks_for_no_more_memory_than_its_samples_need() -> None:
    """Of 12 channels 4 million lost samples would make 400 MB."""
    channels = tuple(replace(describe().channels[0], name=str(i)) for i in range(12))
    made = taken(Describe(SampleFormat.I16, channels))
    block = Data(0, 0, 0, 1, 12, SampleFormat.I16, bytes(24))
    for message in (block, End(1 << 22, 0, 0), replace(block, first_index=(1 << 22) - 1)):
        made.take(Frame(9, 0, message), 0.0)
    made.window = None
    assert made.recording().samples.size <= (1 << 22) + 24
    made.take_note({"event": "window", "first": 0, "count": 1 << 40})
    made.rebooted = True
    assert made.recording().samples.size <= (1 << 22) + 24


@pytest.mark.parametrize("firmware", ["import", "a source of samples"])
def test_no_name_of_a_board_keeps_it_from_being_checked(firmware: str) -> None:
    made = taken(Hello(1, 1, firmware=firmware), *STREAM, replace(END, checksum=1))
    assert verdict(made).grade is Grade.REJECT
    late = [data(first, late_us=3e4 if first >= 800 else 0.0) for first in range(0, COUNT, N)]
    assert verdict(taken(Hello(1, 1, firmware=firmware), *late, END)).grade is Grade.REJECT
