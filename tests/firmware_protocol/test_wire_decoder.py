"""Whatever the wire does to the bytes: no exception, no message that was not sent, no growth."""

import random
import sys
import tracemalloc
from itertools import pairwise

from hypothesis import given, settings, strategies as st
from wire_messages import messages

from firmware_protocol import Data, Decoder, Frame, Log, Message, SampleFormat, Start, encode

sent = st.lists(messages, min_size=1, max_size=8)


def wire_of(sent: list[Message]) -> bytes:
    return b"".join(encode(message, i) for i, message in enumerate(sent))


def cut(wire: bytes, places: list[int]) -> list[bytes]:
    edges = [0, *sorted(place % (len(wire) + 1) for place in places), len(wire)]
    return [wire[a:b] for a, b in pairwise(edges)]


def decode_in_pieces(pieces: list[bytes]) -> tuple[list[Frame], Decoder]:
    decoder = Decoder()
    return [frame for piece in pieces for frame in decoder.feed(piece)], decoder


@given(sent, st.lists(st.integers(0, 10_000), max_size=12))
def test_the_same_messages_come_out_however_the_bytes_are_cut(sent: list[Message], places: list[int]) -> None:
    frames, _ = decode_in_pieces(cut(wire_of(sent), places))
    assert frames == [Frame(i, 0, message) for i, message in enumerate(sent)]


@given(st.binary(max_size=4000), st.lists(st.integers(0, 10_000), max_size=12))
def test_garbage_gives_the_same_counts_however_it_is_cut(noise: bytes, places: list[int]) -> None:
    whole, one = decode_in_pieces([noise])
    parts, many = decode_in_pieces(cut(noise, places))
    assert whole == parts == []
    assert one.statistics == many.statistics


@given(st.binary(max_size=3000), messages)
def test_a_message_after_any_garbage_and_a_zero_is_read(noise: bytes, message: Message) -> None:
    assert Decoder().feed(noise + b"\x00" + encode(message, 5))[-1] == Frame(5, 0, message)


damage = st.lists(
    st.tuples(
        st.sampled_from(["drop", "flip", "insert", "duplicate", "swap"]),
        st.integers(0, 100_000),
        st.integers(1, 255),
        st.integers(1, 40),
    ),
    min_size=1,
    max_size=6,
)


def damaged(wire: bytes, faults: list[tuple[str, int, int, int]]) -> bytes:
    data = bytearray(wire)
    for kind, place, value, length in faults:
        at = place % max(len(data), 1)
        if kind == "drop":
            del data[at : at + length]
        elif kind == "flip" and data:
            data[at] ^= value
        elif kind == "insert":
            data[at:at] = bytes((value * k) % 256 for k in range(length))
        elif kind == "duplicate":
            data[at:at] = data[at : at + length]
        elif kind == "swap":
            data[at : at + 2 * length] = data[at + length : at + 2 * length] + data[at : at + length]
    return bytes(data)


@settings(max_examples=100)
@given(sent, damage)
def test_damaged_bytes_never_give_a_message_that_was_not_sent(
    sent: list[Message], faults: list[tuple[str, int, int, int]]
) -> None:
    honest = {repr(Frame(i, 0, message)) for i, message in enumerate(sent)}
    got = Decoder().feed(damaged(wire_of(sent), faults))
    assert {repr(frame) for frame in got} <= honest


def test_twenty_thousand_damaged_frames_give_none_that_was_not_sent() -> None:
    # Hypothesis looks for odd cases; this looks for rare ones. One in 2**32 would be chance.
    rng = random.Random(1)
    decoder, wrong, passed = Decoder(), 0, 0
    for i in range(20_000):
        message = Data(i * 8, i, 0, 8, 2, SampleFormat.I16, rng.randbytes(32))
        wire = bytearray(encode(message, i))
        for _ in range(rng.randint(1, 3)):
            at = rng.randrange(len(wire) - 1)
            if rng.random() < 0.5:
                wire[at] ^= 1 << rng.randrange(8)
            else:
                del wire[at]
        for frame in decoder.feed(bytes(wire)):
            passed += 1
            wrong += frame != Frame(i, 0, message)
    assert wrong == 0
    assert decoder.statistics.damaged > 19_800
    assert passed < 20


@given(sent, st.integers(0, 100_000))
def test_one_lost_byte_costs_at_most_two_frames(sent: list[Message], place: int) -> None:
    wire = wire_of(sent)
    at = place % len(wire)
    frames = Decoder().feed(wire[:at] + wire[at + 1 :])
    lost = len(sent) - len(frames)
    # A lost delimiter makes two frames one; any other byte is within a single frame.
    assert lost <= (2 if wire[at] == 0 else 1)


def test_a_frame_that_is_too_long_is_counted_once_and_dropped() -> None:
    for size in (1030, 5000, 100_000):
        frames, decoder = decode_in_pieces([b"\x01" * 100] * (size // 100) + [b"\x01" * (size % 100)])
        assert frames == []
        assert decoder.feed(b"\x00" + encode(Start(3), 1)) == [Frame(1, 0, Start(3))]
        assert decoder.statistics.too_long == 1


def test_memory_stays_bounded_without_a_delimiter() -> None:
    decoder, piece = Decoder(), b"\x55" * 4096
    decoder.feed(piece)
    tracemalloc.start()
    for _ in range(2000):
        decoder.feed(piece)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # 8 MB went in; a feed may hold its own piece a few times over, and nothing of the pieces before.
    assert peak < 30_000


def test_what_waits_between_two_calls_is_less_than_a_frame() -> None:
    decoder = Decoder()
    for _ in range(3000):
        decoder.feed(b"\x07")
        assert sys.getsizeof(decoder._pending) < 1100


def test_statistics_once_taken_do_not_change() -> None:
    decoder = Decoder()
    before = decoder.statistics
    decoder.feed(encode(Log("hello"), 0))
    assert before.frames == 0
    assert decoder.statistics.frames == 1
