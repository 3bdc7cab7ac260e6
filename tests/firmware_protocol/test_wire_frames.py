"""A message survives the wire, and the frame is what the page says it is."""

import struct

import pytest
from cobs import cobs
from hypothesis import given, settings, strategies as st
from wire_messages import frame, messages, stuff, u8, u32

from firmware_protocol import (
    ChannelDescription,
    Data,
    Decoder,
    Describe,
    Frame,
    Log,
    Message,
    OtherVersion,
    SampleFormat,
    Start,
    Stop,
    encode,
)


@given(messages, u32, u8)
def test_every_message_comes_back_as_it_was_sent(message: Message, sequence: int, stream: int) -> None:
    assert Decoder().feed(encode(message, sequence, stream)) == [Frame(sequence, stream, message)]


@given(messages)
def test_a_frame_holds_no_zero_but_its_last_byte_and_fits_1030_bytes(message: Message) -> None:
    wire = encode(message, 1)
    assert wire.index(0) == len(wire) - 1
    assert len(wire) <= 1030


def test_a_frame_built_by_hand_is_the_frame_that_encode_makes() -> None:
    plain = struct.pack("<BBBBIQ", 1, 3, 0, 2, 77, 2048)
    assert encode(Start(2048), 77, 2) == frame(plain)


@given(st.binary(max_size=1100))
def test_stuffing_by_hand_agrees_with_the_library(plain: bytes) -> None:
    assert stuff(plain) == cobs.encode(plain)


@pytest.mark.parametrize("length", [253, 254, 255, 507, 508, 509, 1016])
def test_stuffing_agrees_where_a_piece_is_full(length: int) -> None:
    for plain in (b"x" * length, b"x" * length + b"\x00", b"\x00" + b"x" * length):
        assert stuff(plain) == cobs.encode(plain)


def test_a_sequence_counts_on_from_zero_after_2_to_the_32() -> None:
    assert Decoder().feed(encode(Stop(), 2**32 + 5)) == [Frame(5, 0, Stop())]


def test_the_longest_frame_passes_and_one_more_sample_is_refused() -> None:
    def data(n: int) -> Data:
        return Data(0, 0, 0, n, 1, SampleFormat.I16, b"\x01" * (2 * n))

    longest = (1024 - 12 - 24) // 2
    assert Decoder().feed(encode(data(longest), 0))[0].message == data(longest)
    with pytest.raises(ValueError, match="a frame carries at most 1012"):
        encode(data(longest + 1), 0)


def test_the_longest_frame_with_hardly_a_zero_in_it_passes_whole_and_byte_by_byte() -> None:
    # One zero in the header, 1021 bytes without any: COBS needs all of the 5 bytes that it may add.
    ones = 0x0101010101010101
    data = Data(ones, ones, 0x01010101, 494, 1, SampleFormat.I16, b"\x01" * 988)
    sequence = next(i for i in range(ones & 0xFFFFFFFF, 2**32) if len(encode(data, i, 1)) == 1030)
    wire, decoder = encode(data, sequence, 1), Decoder()
    assert decoder.feed(wire) == [Frame(sequence, 1, data)]
    bytewise = [got for k in range(len(wire)) for got in decoder.feed(wire[k : k + 1])]
    assert bytewise == [Frame(sequence, 1, data)]


@pytest.mark.parametrize(
    ("message", "words"),
    [
        (Start(-1), "Start does not fit"),
        (Start(2**64), "Start does not fit"),
        (Log("x" * 256), "at most 255"),
        (Log("\ud800"), "Log does not fit"),
        (Data(0, 0, 0, 2, 2, SampleFormat.I16, b"\x00" * 7), "7 bytes of samples"),
        (Describe(SampleFormat.I16, (ChannelDescription("", "", "", 1, 0, 1),) * 256), "256 channels"),
        (OtherVersion(2), "no message of the wire"),
    ],
)
def test_what_does_not_fit_is_refused_in_words(message: Message, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        encode(message, 0)


@settings(max_examples=50)
@given(messages, st.binary(min_size=1, max_size=20))
def test_fields_of_a_later_minor_version_are_skipped(message: Message, later: bytes) -> None:
    plain = cobs.decode(encode(message, 3)[:-1])[:-4]
    assert Decoder().feed(frame(plain + later)) == [Frame(3, 0, message)]


def test_fields_that_a_later_minor_version_adds_to_a_channel_are_skipped() -> None:
    channel = ChannelDescription("x", "displacement", "m", 1e-6, 0.0, 256.0)
    record = (
        struct.pack("<7d", 1e-6, 0.0, 256.0, *[float("nan")] * 3, 0.0) + b"\x01x\x0cdisplacement\x01m\x00"
    )
    body = bytes((1, 2)) + 2 * (struct.pack("<H", len(record) + 3) + record + b"new")
    got = Decoder().feed(frame(struct.pack("<BBBBI", 1, 0x82, 0, 0, 9) + body))
    assert got == [Frame(9, 0, Describe(SampleFormat.I16, (channel, channel)))]


def test_a_type_of_a_later_minor_version_is_counted_and_skipped() -> None:
    decoder = Decoder()
    assert decoder.feed(frame(struct.pack("<BBBBI", 1, 0xC0, 0, 0, 9) + b"later")) == []
    assert decoder.statistics.unknown == 1


def test_another_major_version_is_noticed_and_not_read() -> None:
    decoder = Decoder()
    assert decoder.feed(encode(Stop(), 4, version=2)) == [Frame(4, 0, OtherVersion(2))]
    assert decoder.statistics.frames == 1


def test_values_of_a_later_minor_version_read_as_other() -> None:
    body = struct.pack("<BBQI", 77, 255, 5, 1) + b"\x00"
    (got,) = Decoder().feed(frame(struct.pack("<BBBBI", 1, 0x87, 0, 0, 0) + body))
    assert got.message.kind.name == "OTHER"


@pytest.mark.parametrize(
    ("code", "body"),
    [
        (0x03, b"\x00" * 7),
        (0x89, b""),
        (0x89, b"\x05abcd"),
        (0x85, struct.pack("<QQIHBB", 0, 0, 0, 2, 1, 1) + b"\x00" * 3),
        (0x85, struct.pack("<QQIHBB", 0, 0, 0, 1, 1, 9) + b"\x00" * 8),
        (0x82, b"\x01"),
        (0x82, b"\x01\x01"),
        (0x82, b"\x01\x01\x39"),
        (0x82, b"\x01\x01\x39\x00" + b"\x00" * 57),
        (0x82, b"\x09\x00"),
    ],
)
def test_a_sound_checksum_around_nonsense_is_counted_as_malformed(code: int, body: bytes) -> None:
    decoder = Decoder()
    assert decoder.feed(frame(struct.pack("<BBBBI", 1, code, 0, 0, 0) + body)) == []
    assert decoder.statistics.malformed == 1


def test_a_text_that_is_not_utf8_is_taken_with_marks_in_it() -> None:
    (got,) = Decoder().feed(frame(struct.pack("<BBBBI", 1, 0x89, 0, 0, 0) + b"\x04g\xfcn!"))
    assert got.message == Log("g\N{REPLACEMENT CHARACTER}n!")


def test_why_a_sound_frame_was_not_understood_is_kept() -> None:
    decoder = Decoder()
    decoder.feed(frame(struct.pack("<BBBBI", 1, 0x89, 0, 0, 0) + b"\x05abcd"))
    assert decoder.statistics.why_malformed == "type 0x89: a text runs past the end of the body"


@pytest.mark.parametrize(("channels", "text"), [(16, 0), (12, 22)])
def test_a_description_holds_as_many_channels_as_the_page_says(channels: int, text: int) -> None:
    one = ChannelDescription("n" * text, "", "", 1.0, 0.0, 256.0)
    assert len(encode(Describe(SampleFormat.I16, (one,) * channels), 0)) <= 1030
    with pytest.raises(ValueError, match="a frame carries at most"):
        encode(Describe(SampleFormat.I16, (one,) * (channels + 1)), 0)
