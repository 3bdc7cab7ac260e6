"""The faults of the line: each does what its name says, the same for the same seed."""

import numpy as np
import pytest

from firmware_protocol import Decoder, Log, encode
from mocks.faults import PER_BYTE, PER_FRAME, Fault, Line, parse_fault

FRAMES = [encode(Log(f"line {i:04d} of a long text"), i) for i in range(2000)]


def sent(*faults: Fault, seed: int = 1) -> bytes:
    line = Line(faults, np.random.default_rng(seed))
    for frame in FRAMES:
        line.put(frame, 0.0)
    return line.due(1e6)


def test_a_line_without_faults_changes_nothing():
    assert sent() == b"".join(FRAMES)


@pytest.mark.parametrize("name", sorted({**PER_BYTE, **PER_FRAME} - {"delayed": 0}.keys()))
def test_every_fault_damages_some_frames_and_no_wrong_message_gets_through(name):
    amount = 0.002 if name in PER_BYTE else 0.05
    data = sent(Fault(name, amount))
    assert data != b"".join(FRAMES)
    decoder = Decoder()
    texts = [frame.message.text for frame in decoder.feed(data)]
    good = {f"line {i:04d} of a long text" for i in range(2000)}
    assert set(texts) <= good
    assert len(set(texts)) > 1500
    if name == "repeated":
        # Binomial: 2000 frames, 5 %: 100 +- 4 x 9.7.
        assert len(texts) - len(set(texts)) == pytest.approx(100, abs=39)
    else:
        assert len(set(texts)) < 2000


@pytest.mark.parametrize(
    ("name", "change"), [("lost", -1), ("inserted", 1), ("duplicated", 1), ("flipped", 0), ("reordered", 0)]
)
def test_faults_of_bytes_come_as_often_as_asked_for(name, change):
    plain = b"".join(FRAMES)
    expected = 0.002 * len(plain)
    difference = len(sent(Fault(name, 0.002))) - len(plain)
    assert difference == pytest.approx(change * expected, abs=4.0 * expected**0.5 if change else 0)


def test_a_seed_repeats_a_fault_exactly():
    assert sent(Fault("flipped", 0.01), seed=4) == sent(Fault("flipped", 0.01), seed=4)
    assert sent(Fault("flipped", 0.01), seed=4) != sent(Fault("flipped", 0.01), seed=5)


def test_delayed_frames_come_late_and_in_order():
    line = Line((Fault("delayed", 0.3),), np.random.default_rng(1))
    for i, frame in enumerate(FRAMES[:50]):
        line.put(frame, i * 0.01)
    early = line.due(0.49)
    rest = line.due(10.0)
    assert rest
    assert early + rest == b"".join(FRAMES[:50])


def test_a_slow_line_carries_as_many_bytes_a_second_as_asked_for():
    line = Line((Fault("slow", 500.0),), np.random.default_rng(1))
    for frame in FRAMES:
        line.put(frame, 0.0)
    carried = sum(len(line.due(0.01 * tick)) for tick in range(1, 1002))
    assert carried == pytest.approx(5000, abs=60)


def test_what_the_link_did_not_take_comes_first_next_time():
    line = Line((), np.random.default_rng(1))
    for frame in FRAMES[:3]:
        line.put(frame, 0.0)
    out = line.due(1.0)
    line.back(out[10:], 1.0)
    line.put(FRAMES[3], 1.0)
    assert out[:10] + line.due(2.0) == b"".join(FRAMES[:4])


def test_a_fault_that_strikes_once_strikes_at_its_time_and_once():
    line = Line((Fault("stall", 2.0, 5.0),), np.random.default_rng(1))
    assert line.strikes(4.9) is None
    assert line.strikes(5.1) == Fault("stall", 2.0, 5.0)
    assert line.strikes(5.2) is None


def test_nothing_passes_while_the_line_is_held():
    line = Line((), np.random.default_rng(1))
    line.put(FRAMES[0], 0.0)
    line.hold(3.0)
    assert line.due(2.9) == b""
    assert line.due(3.1) == FRAMES[0]


def test_faults_are_read_from_their_text():
    random = np.random.default_rng(1)
    assert parse_fault("stall:2.5@6", random) == Fault("stall", 2.5, 6.0)
    assert parse_fault("lost:0.01", random).amount == 0.01
    drawn = parse_fault("unplug", random)
    assert 4.5 <= drawn.at <= 9.0
    with pytest.raises(ValueError, match=r"no fault is called 'gremlin'; there are: lost, .*, wrong-version"):
        parse_fault("gremlin", random, ("wrong-version",))
    with pytest.raises(ValueError, match="with numbers, not 'stall:long'"):
        parse_fault("stall:long", random)
