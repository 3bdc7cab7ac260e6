"""The board's state machine, without a port and with a clock of the test's own."""

import itertools
from zlib import crc32

import numpy as np
import pytest

from firmware_protocol import (
    Ack,
    ChannelDescription,
    Config,
    Data,
    Decoder,
    Describe,
    End,
    Event,
    EventKind,
    Heartbeat,
    Hello,
    HelloRequest,
    Nack,
    NackCode,
    OtherVersion,
    Resend,
    SampleFormat,
    Start,
    Stop,
    TimeSync,
    encode,
)
from mocks.board import Board
from mocks.misconfigurations import Misconfiguration

CHANNELS = (
    ChannelDescription("displacement", "displacement", "m", 1e-6, 4e-4, 256.0),
    ChannelDescription("acceleration", "acceleration", "m/s^2", 1e-3, -0.25, 256.0),
)


class Ramp:
    """Counts: channel 0 the sample's number, channel 1 its negative."""

    def __init__(self) -> None:
        self.at = 0

    def take(self, count: int) -> np.ndarray:
        index = np.arange(self.at, self.at + count)
        self.at += count
        return np.stack([index, -index], axis=1)


class Bench:
    """A board, its clock, and a host's ear at its output."""

    def __init__(
        self,
        speed: float = 1.0,
        misconfiguration: Misconfiguration | None = None,
        source=Ramp,
        memory_s: float = 8.0,
    ) -> None:
        self.now = 100.0
        self.board = Board(
            CHANNELS,
            lambda rate: source(),
            np.random.default_rng(1),
            self.now,
            speed,
            misconfiguration,
            memory_s,
        )
        self.decoder = Decoder()
        self.sequence = 0
        self.frames = []

    def say(self, message) -> int:
        self.board.receive(encode(message, self.sequence), self.now)
        self.sequence += 1
        return self.sequence - 1

    def hear(self, seconds: float = 0.0, room: bool = True, tick: float = 0.01) -> list:
        messages = []
        for _ in range(max(1, round(seconds / tick))):
            if seconds:
                self.now += tick
            for data in self.board.poll(self.now, room):
                frames = self.decoder.feed(data)
                assert len(frames) == 1
                self.frames += frames
                messages += [frame.message for frame in frames]
        return messages


def numbers(data: list[Data]) -> np.ndarray:
    parts = [np.frombuffer(d.samples, d.format.code).reshape(d.n, d.channels) for d in data]
    return np.concatenate(parts)


def of(kind: type, messages: list) -> list:
    return [message for message in messages if isinstance(message, kind)]


def test_hello_is_answered_in_every_state():
    bench = Bench()
    bench.say(HelloRequest())
    assert [type(m) for m in bench.hear()] == [Hello, Describe]
    bench.say(Start())
    bench.hear(0.2)
    bench.say(HelloRequest())
    messages = bench.hear()
    assert of(Hello, messages)
    assert of(Describe, messages)[0].format is SampleFormat.I16


def test_an_idle_board_sends_a_heartbeat_twice_a_second():
    beats = of(Heartbeat, Bench().hear(5.0))
    assert 9 <= len(beats) <= 10
    assert np.all(np.diff([b.uptime_us for b in beats]) == pytest.approx(5e5, abs=2e4))


def test_sampling_yields_each_sample_once_in_order_with_its_time():
    bench = Bench()
    asked = bench.say(Start())
    messages = bench.hear(2.0)
    assert messages[0] == Ack(asked, 3)
    data = of(Data, messages)
    count = sum(d.n for d in data)
    assert 512 - 16 <= count <= 512
    np.testing.assert_array_equal(numbers(data)[:, 0], np.arange(count))
    np.testing.assert_array_equal(numbers(data)[:, 1], -np.arange(count))
    for a, b in itertools.pairwise(data):
        assert b.first_index == a.first_index + a.n
        assert b.board_time_us - a.board_time_us == pytest.approx(a.n / 256.0 * 1e6, abs=1.0)
    assert not of(Heartbeat, messages)


def test_stop_flushes_what_waits_and_end_sums_it_up():
    bench = Bench()
    bench.say(Start())
    messages = bench.hear(1.03)
    bench.say(Stop())
    messages += bench.hear()
    data, end = of(Data, messages), messages[-1]
    assert isinstance(end, End)
    assert end.total_samples == sum(d.n for d in data) == int(1.03 * 256)
    assert end.total_dropped == 0
    assert end.checksum == crc32(b"".join(d.samples for d in data))
    bench.say(Stop())
    assert [type(m) for m in bench.hear()] == [Ack, End]


def test_a_count_ends_the_capture_without_a_stop():
    bench = Bench()
    bench.say(Start(100))
    messages = bench.hear(1.0)
    assert sum(d.n for d in of(Data, messages)) == 100
    assert of(End, messages)[0].total_samples == 100


def test_while_sampling_config_start_and_resend_are_refused_as_busy():
    bench = Bench()
    bench.say(Start())
    bench.hear(0.1)
    for request in (Config(), Start(), Resend(0, 5)):
        bench.say(request)
    assert [m.code for m in of(Nack, bench.hear())] == [NackCode.BUSY] * 3


def test_config_changes_rate_frame_and_format_or_says_why_not():
    bench = Bench()
    bench.say(Config(1000.0, 25, SampleFormat.F64))
    ack, describe = bench.hear()
    assert isinstance(ack, Ack)
    assert describe.format is SampleFormat.F64
    assert {c.rate_hz for c in describe.channels} == {1000.0}
    assert {(c.scale, c.offset) for c in describe.channels} == {(1.0, 0.0)}
    bench.say(Start())
    data = of(Data, bench.hear(1.0))
    assert {d.n for d in data} == {25}
    np.testing.assert_allclose(numbers(data)[:3, 0], [4e-4, 4e-4 + 1e-6, 4e-4 + 2e-6], rtol=1e-12)
    bench.say(Stop())
    bench.hear()
    for wrong in (Config(rate_hz=1e6), Config(samples_per_frame=5000)):
        bench.say(wrong)
        assert bench.hear()[0].code is NackCode.UNSUPPORTED
    bench.say(Config())
    assert bench.hear()[1].channels[0].rate_hz == 1000.0  # refused: nothing has changed


@pytest.mark.parametrize("rate", [5.0, 7.0, 20000.0])
def test_slow_and_fast_rates_keep_the_times_of_the_protocol(rate):
    bench = Bench()
    bench.say(Config(rate))
    bench.hear()
    bench.say(Start())
    said = []
    for _ in range(300):
        bench.now += 0.01
        if bench.hear():
            said.append(bench.now)
    assert np.max(np.diff(said)) <= 0.25 + 0.011 if rate < 10 else 0.1 + 0.011
    bench.say(Stop())
    assert bench.hear()[-1].total_dropped == 0


def test_resend_gives_the_same_bytes_again():
    bench = Bench()
    bench.say(Start())
    data = of(Data, bench.hear(3.0))
    bench.say(Stop())
    bench.hear()
    bench.say(Resend(123, 77))
    again = bench.hear()
    assert isinstance(again[-1], Ack)
    np.testing.assert_array_equal(numbers(of(Data, again))[:, 0], np.arange(123, 200))
    assert again[0].first_index == 123
    original = next(d for d in data if d.first_index <= 123 < d.first_index + d.n)
    into = (123 - original.first_index) / 256.0 * 1e6
    assert again[0].board_time_us == pytest.approx(original.board_time_us + into, abs=1.0)


def test_resend_reaches_back_eight_seconds_and_no_further():
    bench = Bench()
    bench.say(Start())
    bench.hear(10.0)
    bench.say(Stop())
    end = bench.hear()[-1]
    oldest = end.total_samples - 8 * 256
    bench.say(Resend(oldest, 8 * 256))
    messages = bench.hear()
    assert isinstance(messages[-1], Ack)
    assert sum(d.n for d in of(Data, messages)) == 8 * 256
    bench.say(Resend(oldest - 10, 20))
    messages = bench.hear()
    assert messages[-1].code is NackCode.NOT_HELD
    assert sum(d.n for d in of(Data, messages)) == 10


def test_a_host_that_does_not_read_loses_counted_samples():
    bench = Bench()
    bench.say(Start())
    messages = bench.hear(1.0)
    messages += bench.hear(4.0, room=False)
    messages += bench.hear(1.0)
    bench.say(Stop())
    messages += bench.hear()
    data, end = of(Data, messages), messages[-1]
    dropped = [d for d in data if d.dropped_before]
    assert len(dropped) == 1
    expected = 0
    for d in data:
        assert d.first_index == expected + d.dropped_before
        expected = d.first_index + d.n
    assert end.total_dropped == dropped[0].dropped_before == pytest.approx(2.0 * 256, abs=20)
    assert end.total_samples == end.total_dropped + sum(d.n for d in data)
    overruns = [e for e in of(Event, messages) if e.kind is EventKind.OVERRUN]
    assert len(overruns) == 1
    bench.say(Resend(dropped[0].first_index - 5, 5))
    assert bench.hear()[-1].code is NackCode.NOT_HELD


def test_at_speed_zero_the_board_samples_only_when_there_is_room():
    bench = Bench(speed=0.0)
    bench.say(Start())
    bench.hear()
    assert not of(Data, bench.hear(1.0, room=False))
    assert sum(d.n for d in of(Data, bench.hear(1.0))) == 100 * 16  # one frame for each of 100 turns
    bench.say(Stop())
    assert of(End, bench.hear())[0].total_dropped == 0


def test_timesync_returns_the_hosts_number_and_the_boards_clock():
    bench = Bench()
    bench.hear(1.5)
    bench.say(TimeSync(77))
    answer = of(TimeSync, bench.hear())[0]
    assert answer.host_time_us == 77
    assert answer.board_time_us == pytest.approx(1.5e6, abs=10.0)


def test_frame_sequence_counts_every_frame():
    bench = Bench()
    bench.say(Start())
    bench.hear(1.0)
    bench.say(Stop())
    bench.hear(2.0)
    assert [f.sequence for f in bench.frames] == list(range(len(bench.frames)))


def test_a_reboot_is_seen_by_another_boot_id_and_loses_the_capture():
    bench = Bench()
    bench.say(HelloRequest())
    before = of(Hello, bench.hear())[0]
    bench.say(Start())
    bench.hear(1.0)
    bench.board.reboot(bench.now)
    assert not of(Data, bench.hear(1.0))
    bench.say(HelloRequest())
    assert of(Hello, bench.hear())[0].boot_id != before.boot_id
    bench.say(Stop())
    assert bench.hear()[-1] == End(0, 0, 0)


def test_what_a_board_says_is_skipped_when_the_line_echoes_it():
    bench = Bench()
    bench.say(Heartbeat(1, 0, 0))
    assert not of(Nack, bench.hear())


def test_another_major_version_of_the_host_is_answered_by_hello():
    bench = Bench()
    bench.board.receive(encode(HelloRequest(), 0, version=3), bench.now)
    assert isinstance(bench.hear()[0], Hello)


def test_a_board_of_a_wrong_version():
    bench = Bench(misconfiguration=Misconfiguration(wrong_version=True))
    bench.say(HelloRequest())
    assert bench.hear() == [OtherVersion(2), OtherVersion(2)]


def test_a_wrong_rate_shows_in_the_boards_own_time_stamps():
    bench = Bench(misconfiguration=Misconfiguration(rate=1.01, time_stamp_rate=1.01))
    bench.say(Start())
    data = of(Data, bench.hear(10.0))
    rate = (
        (data[-1].first_index - data[0].first_index) * 1e6 / (data[-1].board_time_us - data[0].board_time_us)
    )
    assert rate == pytest.approx(256.0 * 1.01, rel=1e-6)
    assert data[-1].first_index + data[-1].n == pytest.approx(2560 * 1.01, abs=17)


def test_a_fast_clock_shows_against_the_hosts_clock_only():
    bench = Bench(misconfiguration=Misconfiguration(rate=1.002, clock=1.002))
    bench.say(Start())
    data = of(Data, bench.hear(20.0))
    rate = data[-1].first_index * 1e6 / (data[-1].board_time_us - data[0].board_time_us)
    assert rate == pytest.approx(256.0, rel=1e-6)
    bench.say(TimeSync(0))
    assert of(TimeSync, bench.hear())[0].board_time_us == pytest.approx(20.04e6, rel=1e-6)
    assert data[-1].first_index + data[-1].n == pytest.approx(20 * 256 * 1.002, abs=17)


def test_a_wrong_description_contradicts_data():
    bench = Bench(misconfiguration=Misconfiguration(describe=True))
    bench.say(HelloRequest())
    describe = of(Describe, bench.hear())[0]
    bench.say(Start())
    data = of(Data, bench.hear(0.5))[0]
    assert (len(describe.channels), describe.format) != (data.channels, data.format)


def test_a_wrong_counter_leaves_a_hole_that_nobody_can_fill():
    bench = Bench(misconfiguration=Misconfiguration(counter=True))
    bench.say(Start())
    messages = bench.hear(5.0)
    bench.say(Stop())
    messages += bench.hear()
    data, end = of(Data, messages), messages[-1]
    holes = [b.first_index - a.first_index - a.n for a, b in itertools.pairwise(data)]
    assert sorted(set(holes)) == [0, 7]
    assert end.checksum != crc32(b"".join(d.samples for d in data))


def test_wrong_wiring_changes_the_numbers_as_named():
    def first(misconfiguration: Misconfiguration) -> np.ndarray:
        bench = Bench(misconfiguration=misconfiguration)
        bench.say(Start())
        return numbers(of(Data, bench.hear(0.5)))[5]

    assert first(Misconfiguration()).tolist() == [5, -5]
    assert first(Misconfiguration(swapped=True)).tolist() == [-5, 5]
    assert first(Misconfiguration(reversed=True)).tolist() == [5, 5]
    assert first(Misconfiguration(dead_channel=1)).tolist() == [5, 0]


def test_numbers_at_the_end_of_the_range_are_reported():
    class Full(Ramp):
        def take(self, count: int) -> np.ndarray:
            return np.where(super().take(count) > 100, 32767, 0)

    bench = Bench(source=Full)
    bench.say(Start())
    events = of(Event, bench.hear(2.0))
    assert events[0].kind is EventKind.SATURATION
    assert (events[0].channel, events[0].index) == (0, 101)
    assert len(events) <= 8


def test_descriptions_are_not_shared_between_boards():
    bench, other = Bench(), Bench()
    bench.say(Config(500.0))
    bench.hear()
    other.say(HelloRequest())
    assert of(Describe, other.hear())[0].channels[0].rate_hz == 256.0
