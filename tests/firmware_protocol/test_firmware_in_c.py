"""The example firmware is a board of its own: it follows the page, and releases the paper's mass."""

import math
import re
import struct
import subprocess
import time
import zlib
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest
from bench_host import BenchHost, Board
from c_compiler import C_FOLDER, ROOT, SANITIZE, STRICT, build, compiler
from wire_messages import frame

from firmware_protocol import (
    Ack,
    Clock,
    Config,
    Data,
    Describe,
    End,
    Event,
    EventKind,
    Heartbeat,
    Hello,
    HelloRequest,
    Log,
    Nack,
    NackCode,
    Resend,
    SampleFormat,
    Start,
    TimeSync,
    encode,
)

SOURCES = [C_FOLDER / name for name in ("main.c", "board.c", "hardware_host.c")]
SPEED = 20
KEPT = 4096
# Closed forms of the mass on springs, from the paper's means (a board's own truth, not the station's).
W0 = math.sqrt(13115 / 21.36)
DRY, VISCOUS, RELEASED_AT = 0.13, 0.277, 0.020


@pytest.fixture(scope="module")
def firmware(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build(tmp_path_factory.mktemp("c") / "firmware", SOURCES, STRICT + SANITIZE)


@pytest.fixture
def options() -> tuple[str, ...]:
    return ()


@pytest.fixture
def host(firmware: Path, options: tuple[str, ...]) -> Iterator[BenchHost]:
    board = Board(firmware, "--speed", str(SPEED), *options)
    host = BenchHost(board.path)
    yield host
    host.close()
    board.end()


def capture(host: BenchHost, count: int) -> End:
    """Let the board take `count` samples and end by itself."""
    before = len(host.messages(End))
    assert isinstance(host.ask(Start(count)), Ack)
    host.read_until(lambda: len(host.messages(End)) > before, seconds=count / 256 / SPEED + 5)
    return host.messages(End)[-1]


def test_it_says_who_it_is_and_what_it_measures(host: BenchHost) -> None:
    host.hello()
    describe = host.next(Describe)
    (hello,) = host.messages(Hello)
    assert (hello.major, hello.minor, hello.board) == (1, 1, "hardware_host")
    assert [channel.quantity for channel in describe.channels] == ["displacement", "acceleration"]
    assert [channel.unit for channel in describe.channels] == ["m", "m/s^2"]
    assert {channel.rate_hz for channel in describe.channels} == {256.0}
    assert describe.format is SampleFormat.I16


def test_it_states_the_error_of_its_clock_behind_each_description(host: BenchHost) -> None:
    host.hello()
    assert host.next(Clock) == Clock(50.0)
    assert isinstance(host.ask(Config(rate_hz=128)), Ack)
    host.read_until(lambda: len(host.messages(Clock)) == 2)
    seen = [type(frame.message) for frame in host.frames if isinstance(frame.message, Describe | Clock)]
    assert seen == [Describe, Clock] * 2


def test_a_description_too_long_for_a_frame_is_complained_of(tmp_path: Path) -> None:
    board = Board(build(tmp_path / "short", SOURCES, [*STRICT, "-DBOARD_FRAME=150"]))
    host = BenchHost(board.path)
    host.send_bytes(b"\0" + encode(HelloRequest(), 0))
    assert "DESCRIBE does not fit a frame" in host.next(Log).text
    assert host.messages(Describe) == []
    host.close()
    board.end()


def test_noise_before_the_greeting_does_no_harm(host: BenchHost) -> None:
    host.send_bytes(b"AT+GMM\r\n" * 40 + encode(Start(5), 0)[:-3])
    host.hello()
    assert host.next(Hello).board == "hardware_host"
    assert host.messages(Data) == []


def test_another_boot_has_another_identity(firmware: Path) -> None:
    seen = set()
    for _ in range(2):
        board = Board(firmware)
        host = BenchHost(board.path)
        host.hello()
        seen.add(host.next(Hello).boot_id)
        host.close()
        board.end()
    assert len(seen) == 2


def test_it_beats_twice_a_second_while_idle(host: BenchHost) -> None:
    host.read_until(lambda: len(host.messages(Heartbeat)) >= 9)
    times = [beat.uptime_us for beat in host.messages(Heartbeat)]
    steps = [b - a for a, b in pairwise(times)]
    # Half a second of the board's clock, which runs 20 times as fast here; a sanitized build on a busy
    # machine may come a scheduler's slice late, but never early.
    assert min(steps) >= 500_000
    assert sorted(steps)[len(steps) // 2] < 700_000


def test_a_capture_holds_every_sample_once_and_its_checksum_agrees(host: BenchHost) -> None:
    end = capture(host, 1000)
    samples = host.samples()
    assert sorted(samples) == list(range(1000))
    assert (end.total_samples, end.total_dropped) == (1000, 0)
    assert end.checksum == zlib.crc32(b"".join(samples[i] for i in range(1000)))
    sequences = [frame.sequence for frame in host.frames]
    assert sequences == list(range(sequences[0], sequences[0] + len(sequences)))


def test_the_boards_clock_times_the_samples(host: BenchHost) -> None:
    capture(host, 512)
    data = host.messages(Data)
    begin = data[0].board_time_us
    for message in data:
        # Rounded to a microsecond.
        assert abs(message.board_time_us - begin - message.first_index / 256 * 1e6) <= 1


def test_the_mass_loses_the_amplitude_that_its_friction_takes(host: BenchHost) -> None:
    capture(host, (3 + 2) * 256)
    samples = host.samples()
    x = [struct.unpack("<2h", samples[i])[0] * 1e-6 for i in range(len(samples))]
    rest = x[: 3 * 256]
    assert abs(sum(rest) / len(rest) - RELEASED_AT) < 1e-6  # 5 um of noise over 768 samples
    # Each half cycle: the centre moves by mu_0 / w0^2 and viscous friction scales what is left.
    decay = VISCOUS / 2
    w = math.sqrt(W0**2 - decay**2)
    shift, shrink = DRY / W0**2, math.exp(-decay * math.pi / w)
    turning = RELEASED_AT
    for half_cycle in range(1, 9):
        turning = (
            -(abs(turning) - shift) * shrink + shift
            if turning > 0
            else (abs(turning) - shift) * shrink - shift
        )
        at = (3 + half_cycle * math.pi / w + 0.0013) * 256
        near = [abs(x[i]) for i in range(int(at) - 2, int(at) + 4)]
        # The nearest sample is at most half a sample from the turning point, where the curve has fallen by
        # a (w dt)^2 / 2 = 0.12 %; 5 um of noise, the largest of six.
        assert max(near) == pytest.approx(abs(turning), rel=1.5e-3, abs=20e-6)


def test_the_displacement_is_late_and_the_acceleration_is_not(host: BenchHost) -> None:
    capture(host, (3 + 2) * 256)
    samples = host.samples()
    pairs = [struct.unpack("<2h", samples[i]) for i in range(len(samples))]
    crossings = []
    for channel in (0, 1):
        values = [pair[channel] for pair in pairs]
        i = next(i for i in range(3 * 256 + 4, len(values)) if values[i - 1] * values[i] < 0)
        crossings.append(i - 1 + values[i - 1] / (values[i - 1] - values[i]))
    late = (crossings[0] - crossings[1]) / 256
    # Friction alone moves the zeros apart: on the first way through (v < 0) the acceleration is 0 where
    # w0^2 x = mu_0 + mu_1 |v|, which comes before x = 0. |v| is w0 times the amplitude there, nearly; a
    # straight line between samples and the noise are worth 50 us.
    speed = W0 * (RELEASED_AT - DRY / W0**2)
    friction = (DRY + VISCOUS * speed) / (W0**2 * speed)
    assert late == pytest.approx(0.0013 + friction, abs=5e-5)


def test_what_the_wire_lost_is_sent_again(host: BenchHost) -> None:
    end = capture(host, 600)
    complete = host.samples()
    host.frames = [
        f for f in host.frames if not isinstance(f.message, Data) or f.message.first_index not in (160, 176)
    ]
    assert len(host.samples()) == 568
    assert isinstance(host.ask(Resend(160, 32)), Ack)
    again = host.samples()
    assert again == complete
    assert end.checksum == zlib.crc32(b"".join(again[i] for i in range(600)))


def test_the_newest_samples_are_kept_and_older_ones_are_reported(host: BenchHost) -> None:
    capture(host, KEPT + 100)
    complete = host.samples()
    host.frames = []
    answer = host.ask(Resend(90, 20))
    assert isinstance(answer, Nack)
    assert answer.code is NackCode.NOT_HELD
    assert host.samples() == {i: complete[i] for i in range(100, 110)}
    assert isinstance(host.ask(Resend(100, KEPT)), Ack)
    assert host.samples() == {i: complete[i] for i in range(100, KEPT + 100)}


@pytest.mark.parametrize("asked", [Resend(590, 20), Resend(2**64 - 1, 5), Resend(10_000, 1)])
def test_samples_that_never_were_are_not_held(host: BenchHost, asked: Resend) -> None:
    capture(host, 600)
    answer = host.ask(asked)
    assert isinstance(answer, Nack)
    assert answer.code is NackCode.NOT_HELD


def test_stop_ends_a_capture_and_says_so_again_when_asked_again(host: BenchHost) -> None:
    assert isinstance(host.ask(Start()), Ack)
    host.read_until(lambda: len(host.messages(Data)) >= 5)
    end = host.stop()
    assert len(host.samples()) == end.total_samples
    assert host.stop() == end


def test_a_new_start_begins_at_index_0(host: BenchHost) -> None:
    capture(host, 100)
    host.frames = []
    capture(host, 60)
    assert sorted(host.samples()) == list(range(60))


@pytest.mark.parametrize("request_", [Start(), Config(), Resend(0, 1)])
def test_while_it_samples_it_is_busy(host: BenchHost, request_: Start | Config | Resend) -> None:
    host.ask(Start())
    answer = host.ask(request_)
    assert isinstance(answer, Nack)
    assert answer.code is NackCode.BUSY
    host.stop()


def test_it_answers_hello_while_it_samples_and_loses_nothing(host: BenchHost) -> None:
    host.ask(Start(300))
    host.hello()
    host.next(Describe)
    host.next(End)
    assert sorted(host.samples()) == list(range(300))


@pytest.mark.parametrize(
    "config", [Config(rate_hz=100_000.0), Config(format=SampleFormat.F64), Config(samples_per_frame=5000)]
)
def test_settings_that_it_cannot_do_are_refused_and_change_nothing(host: BenchHost, config: Config) -> None:
    answer = host.ask(config)
    assert isinstance(answer, Nack)
    assert answer.code is NackCode.UNSUPPORTED
    assert answer.text
    host.hello()
    assert host.next(Describe).channels[0].rate_hz == 256


def test_settings_that_it_can_do_are_described(host: BenchHost) -> None:
    assert isinstance(host.ask(Config(rate_hz=128.0, samples_per_frame=8)), Ack)
    host.read_until(lambda: bool(host.messages(Describe)))
    assert host.messages(Describe)[-1].channels[1].rate_hz == 128
    capture(host, 64)
    assert {data.n for data in host.messages(Data)} <= set(range(1, 9))


def test_a_slow_rate_still_shows_that_the_board_is_alive(host: BenchHost) -> None:
    host.ask(Config(rate_hz=5.0))
    host.ask(Start())
    begin = len(host.frames)
    host.read_until(lambda: len(host.frames) >= begin + 30)
    host.stop()
    sent = host.messages(Data)[:-1]  # what STOP sends may be any number
    assert len(sent) >= 10
    assert min(data.n for data in sent) == 1  # a busy computer lets some samples pile up, not all


def test_the_clocks_can_be_compared(host: BenchHost) -> None:
    host.send(TimeSync(123_456_789))
    first = host.next(TimeSync)
    time.sleep(0.05)
    host.send(TimeSync(2**64 - 1))
    second = host.next(TimeSync)
    assert (first.host_time_us, second.host_time_us) == (123_456_789, 2**64 - 1)
    assert second.board_time_us - first.board_time_us >= 0.05e6 * SPEED


def test_a_request_of_a_later_version_is_refused(host: BenchHost) -> None:
    host.send_bytes(frame(struct.pack("<BBBBI", 1, 0x40, 0, 0, 99) + b"later"))
    nack = host.next(Nack)
    assert (nack.request_sequence, nack.request_type, nack.code) == (99, 0x40, NackCode.NOT_UNDERSTOOD)


def test_a_host_of_another_major_version_learns_ours(host: BenchHost) -> None:
    host.send_bytes(encode(HelloRequest(2, 0), 0, version=2))
    assert host.next(Hello).major == 1


def test_a_line_that_echoes_starts_no_endless_talk(host: BenchHost) -> None:
    host.send_bytes(
        encode(Ack(0, 3), 0) + encode(Hello(1, 1), 1) + frame(struct.pack("<BBBBI", 1, 0xC1, 0, 0, 9))
    )
    host.read_until(lambda: len(host.messages(Heartbeat)) >= 4)
    assert not host.messages(Nack)
    assert not host.messages(Hello)


def test_a_host_that_reads_too_rarely_learns_how_many_samples_it_lost(host: BenchHost) -> None:
    host.ask(Start())
    host.read_until(lambda: len(host.messages(Data)) >= 3)
    time.sleep(2 + (KEPT / 256 + 2) / SPEED)  # the kernel's buffer, then the board's, then some
    host.read_until(lambda: any(data.dropped_before for data in host.messages(Data)))
    end = host.stop()
    data = host.messages(Data)
    for before, after in pairwise(data):
        assert after.first_index == before.first_index + before.n + after.dropped_before
    assert end.total_dropped == sum(message.dropped_before for message in data) > 0
    assert len(host.samples()) + end.total_dropped == end.total_samples
    assert host.messages(Event)[0].kind is EventKind.OVERRUN


@pytest.mark.parametrize("options", [("--sensor-fault", "90", "40")])
def test_samples_that_a_sensor_did_not_give_are_counted(host: BenchHost) -> None:
    end = capture(host, 256)
    assert sorted(host.samples()) == [*range(90), *range(130, 256)]
    assert end.total_dropped == 40
    assert [
        (data.first_index, data.dropped_before) for data in host.messages(Data) if data.dropped_before
    ] == [(130, 40)]
    answer = host.ask(Resend(80, 60))
    assert isinstance(answer, Nack)


@pytest.mark.parametrize("options", [("--pause", "200", "0.018")])
def test_a_pause_that_nobody_counted_stands_in_the_boards_own_times(host: BenchHost) -> None:
    host.ask(Start(512))
    host.read_until(lambda: bool(host.messages(End)))
    late = [d.board_time_us - 1e6 * d.first_index / 256 for d in host.messages(Data)]
    steps = [after - before for before, after in pairwise(late) if abs(after - before) > 2]
    # one step, of the pause (us, rounded); no frame is missing
    assert steps == pytest.approx([18000], abs=2)
    assert len(host.samples()) == 512


@pytest.mark.parametrize("flags", [["-Os"], ["-O2"]])
def test_the_firmware_compiles_without_a_warning(tmp_path: Path, flags: list[str]) -> None:
    build(tmp_path / "firmware", SOURCES, STRICT + flags)


def test_the_firmware_asks_for_no_memory() -> None:
    for name in ("wire.h", "board.h", "board.c", "ring.h", "timing.h", "sensors.h", "main.c"):
        assert "alloc" not in (C_FOLDER / name).read_text().replace("no allocation", "")


def test_the_hardware_layer_to_start_from_compiles_without_a_warning(tmp_path: Path) -> None:
    source = ROOT / "docs" / "hardware_mine.c"
    build(tmp_path / "hardware_mine.o", [source], [*STRICT, "-Os", "-c"])


def test_the_command_on_the_page_builds_the_example(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "firmware.md").read_text("utf-8")
    (command,) = re.findall(r"^cc .*$", page, re.M)
    compiler()
    command = command.replace("build/board", str(tmp_path / "board"))
    subprocess.run(command, shell=True, cwd=ROOT, check=True, timeout=60)
    assert (tmp_path / "board").exists()


def test_a_request_of_another_stream_is_nobodys(host: BenchHost) -> None:
    host.send_bytes(b"\0" + encode(Start(5), 0, stream=1))
    host.hello()
    host.next(Hello)
    assert host.messages(Data) == []
    assert host.messages(Ack) == []


@pytest.mark.parametrize(("channels", "frame"), [(16, 1024), (3, 240)])
def test_more_channels_than_a_description_carries_do_not_compile(
    tmp_path: Path, channels: int, frame: int
) -> None:
    source = tmp_path / "many.c"
    source.write_text('#include "board.h"\nint main(void) { return 0; }\n')

    def said(count: int) -> str:
        sizes = (f"-DBOARD_CHANNELS={count}", f"-DBOARD_FRAME={frame}")
        command = [compiler(), "-fsyntax-only", *sizes, f"-I{C_FOLDER}", str(source)]
        return subprocess.run(command, capture_output=True, text=True, timeout=60).stderr

    assert said(channels) == ""
    assert "do not fit the frame of DESCRIBE" in said(channels + 1)
