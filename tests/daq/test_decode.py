import numpy as np
import pytest
from hypothesis import given, strategies as st
from scripted_board import RATE, decay, describe

from daq.decode import Assembly, Block
from daq.errors import DataLost
from daq.quality import integrity
from daq.recording import Gap
from firmware_protocol import (
    ChannelDescription,
    Data,
    Decoder,
    Describe,
    End,
    Frame,
    Hello,
    SampleFormat,
    encode,
)

N = 16
SAMPLES = decay(320)


def data(first: int, n: int = N, dropped: int = 0, samples: np.ndarray = SAMPLES) -> Data:
    part = samples[:, first : first + n].T.astype("<f8").tobytes()
    return Data(first, round(first / RATE * 1e6), dropped, n, 2, SampleFormat.F64, part)


def assembly(*messages: object) -> Assembly:
    made = Assembly()
    for sequence, message in enumerate((Hello(1, 1), describe(), *messages)):
        made.take(Frame(sequence, 0, message), 0.0)  # type: ignore[arg-type]
    return made


def test_samples_come_back_bit_by_bit() -> None:
    recording = assembly(*(data(i) for i in range(0, 320, N))).recording()
    assert np.array_equal(recording.samples, SAMPLES)
    assert recording.valid.all()
    assert recording.gaps == ()
    assert recording.rate == RATE


def test_counts_become_si_units() -> None:
    description = Describe(
        SampleFormat.I16, (ChannelDescription("x", "displacement", "m", 1e-6, 5e-4, 100.0),)
    )
    made = Assembly()
    counts = np.array([-32768, 0, 32767], "<i2").tobytes()
    for message in (description, Data(0, 0, 0, 3, 1, SampleFormat.I16, counts)):
        made.take(Frame(0, 0, message), 0.0)
    assert made.recording().samples[0] == pytest.approx([-32.268e-3, 5e-4, 33.267e-3], rel=1e-12)


def test_a_frame_lost_on_the_wire_is_a_gap_of_the_wire() -> None:
    made = assembly(data(0), data(32), data(48))
    assert made.missing() == (Gap(16, 16, "wire"),)
    recording = made.recording()
    assert not recording.valid[16:32].any()
    assert np.isnan(recording.samples[:, 16:32]).all()


def test_an_overrun_of_the_board_is_distinguished_from_a_loss_on_the_wire() -> None:
    made = assembly(data(0), data(64, dropped=20), data(80))
    assert made.missing() == (Gap(16, 28, "wire"), Gap(44, 20, "overrun"))


def test_losses_are_reported_as_they_are_noticed() -> None:
    made = assembly(data(0))
    happened = made.take(Frame(9, 0, data(64, dropped=20)), 0.0)
    assert [h for h in happened if isinstance(h, Gap)] == [Gap(16, 28, "wire"), Gap(44, 20, "overrun")]
    assert [h.first for h in happened if isinstance(h, Block)] == [64]


def test_a_new_boot_is_a_reboot_and_its_samples_are_not_mixed_in() -> None:
    made = assembly(data(0), data(16))
    made.take_note({"event": "window", "first": 0, "count": 64, "trigger": None})
    happened = made.take(Frame(0, 0, Hello(2, 1)), 0.0)
    made.take(Frame(1, 0, data(0, samples=SAMPLES + 1)), 0.0)
    assert happened == (Gap(32, 32, "reboot"),)
    assert made.missing() == (Gap(32, 32, "reboot"),)
    assert np.array_equal(made.recording().samples[:, :32], SAMPLES[:, :32])


def test_samples_sent_again_fill_the_gap_however_they_are_cut() -> None:
    made = assembly(data(0), data(48), End(64, 0, 0), data(16, 11), data(27, 21))
    assert made.missing() == ()
    assert np.array_equal(made.recording().samples, SAMPLES[:, :64])


def test_a_frame_that_comes_twice_counts_once() -> None:
    made = assembly(data(0), data(16))
    made.take(Frame(3, 0, data(16)), 0.0)
    assert made.samples.duplicates == 1
    assert made.contradictions == []
    assert made.recording().samples.shape == (2, 32)


def test_a_frame_that_comes_late_fills_its_gap() -> None:
    made = Assembly()
    for sequence, message in ((0, describe()), (1, data(0)), (3, data(32)), (2, data(16))):
        made.take(Frame(sequence, 0, message), 0.0)
    assert made.contradictions == []
    assert made.missing() == ()


def test_an_index_that_goes_back_is_a_contradiction() -> None:
    made = assembly(data(0), data(16), data(0))
    assert "went back" in made.contradictions[0]


def test_an_index_that_jumps_to_the_end_of_time_takes_no_memory() -> None:
    made = assembly(data(0))
    lie = Data(1 << 60, 0, 0, 1, 2, SampleFormat.F64, bytes(16))
    assert made.take(Frame(9, 0, lie), 0.0) == ()
    assert "jumped" in made.contradictions[0]
    assert made.recording().samples.shape == (2, 16)


def test_samples_of_another_number_of_channels_are_a_contradiction() -> None:
    made = assembly(Data(0, 0, 0, 1, 3, SampleFormat.F64, bytes(24)))
    assert "3 channels, but 2 were described" in made.contradictions[0]


def test_the_checksum_of_all_samples_is_compared() -> None:
    from zlib import crc32

    check = crc32(data(0, 32).samples)
    whole = (data(0), data(16))

    def said(*messages: object) -> tuple[list[str], list[str]]:
        remarks: list[str] = []
        return [found.reason for found in integrity(assembly(*messages), remarks)], remarks

    assert said(*whole, End(32, 0, check)) == ([], ["the board's checksum of all its samples agrees"])
    assert said(*whole, End(32, 0, check ^ 1)) == (["the board's checksum of all samples does not agree"], [])
    unchecked = "the board's checksum could not be checked: "
    lost = f"{unchecked}16 samples that it covers are lost, 16 of the recording or after it"
    assert said(data(0), End(32, 0, check)) == ([lost], [])
    assert said(*whole) == ([f"{unchecked}the board's END never came"], [])


def test_a_number_that_is_none_is_marked() -> None:
    broken = SAMPLES[:, :32].copy()
    broken[1, 5] = np.inf
    recording = assembly(data(0, 32, samples=broken)).recording()
    assert recording.gaps == (Gap(5, 1, "not a number"),)
    assert np.isnan(recording.samples[:, 5]).all()


def test_a_window_cuts_the_recording_out_of_the_stream() -> None:
    made = assembly(*(data(i) for i in range(0, 320, N)))
    made.take_note({"event": "window", "first": 100, "count": 60, "trigger": 120})
    recording = made.recording()
    assert np.array_equal(recording.samples, SAMPLES[:, 100:160])
    assert recording.trigger == 20


def test_nothing_received_is_said_in_words() -> None:
    with pytest.raises(DataLost, match="no sample was received"):
        assembly().recording()


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan"), float("inf"), 1e300])
def test_an_absurd_rate_is_a_contradiction(rate: float) -> None:
    made = Assembly()
    made.take(Frame(0, 0, describe(rate)), 0.0)
    assert made.description is None
    assert "rate" in made.contradictions[0]


@given(st.binary(max_size=400), st.lists(st.integers(0, 19), max_size=40), st.data())
def test_whatever_arrives_nothing_raises(garbage: bytes, blocks: list[int], draw: st.DataObject) -> None:
    stream = b"".join(
        encode(m, i) for i, m in enumerate([Hello(1, 1), describe(), *(data(16 * b) for b in blocks)])
    )
    at = draw.draw(st.integers(0, len(stream)))
    decoder, made = Decoder(), Assembly()
    for frame in decoder.feed(stream[:at] + garbage + stream[at:]):
        made.take(frame, 0.0)
    lost = {i for gap in made.missing() for i in range(gap.first, gap.first + gap.count)}
    held = {16 * b + i for b in blocks for i in range(16)}
    assert not lost & {i for i in held if i < made.stop} or made.contradictions or garbage


@given(st.lists(st.integers(1, 60), min_size=1, max_size=40))
def test_the_cut_into_reads_does_not_matter(cuts: list[int]) -> None:
    stream = b"".join(encode(m, i) for i, m in enumerate([Hello(1, 1), describe(), data(0), data(32)]))
    decoder, made, at = Decoder(), Assembly(), 0
    for cut in cuts:
        for frame in decoder.feed(stream[at : at + cut]):
            made.take(frame, 0.0)
        at += cut
    for frame in decoder.feed(stream[at:]):
        made.take(frame, 0.0)
    assert made.missing() == (Gap(16, 16, "wire"),)


def test_the_clock_of_the_board_is_measured() -> None:
    wrong = [
        Data(i, round(i / (RATE * 1.01) * 1e6), 0, N, 2, SampleFormat.F64, data(i).samples)
        for i in range(0, 320, N)
    ]
    clock = assembly(*wrong).samples.board_clock()
    assert clock is not None
    # microseconds over 1.2 s: one part in a million
    assert clock.rate == pytest.approx(RATE * 1.01, rel=1e-6)


def test_an_end_before_the_first_sample_belongs_to_the_capture_before() -> None:
    made = assembly(End(0, 0, 0), *(data(i) for i in range(0, 320, N)))
    assert np.array_equal(made.recording().samples, SAMPLES)
    assert made.contradictions == []


def test_samples_asked_for_after_an_end_that_came_first_are_taken() -> None:
    made = assembly(End(320, 0, 0), *(data(i) for i in range(0, 320, N)))
    assert np.array_equal(made.recording().samples, SAMPLES)
    assert made.end == End(320, 0, 0)
