"""The double on a real line, met by a host that knows the wire and nothing else."""

import itertools
import json
import signal
import subprocess
import sys
import threading
import time
from zlib import crc32

import numpy as np
import pytest
from tiny_host import ROOT, TinyHost, running_double, values

from firmware_protocol import (
    Ack,
    Data,
    End,
    Event,
    EventKind,
    Heartbeat,
    Hello,
    HelloRequest,
    OtherVersion,
    Resend,
    Start,
    Stop,
    TimeSync,
)
from mocks.cli import main
from mocks.forces import Effect
from mocks.in_process import running
from mocks.testbed import Bench, Release, simulate_channels

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="pseudo terminals are not on Windows")
SECONDS = 13  # Of bench time: rest, pull, hold and 9 s of decay.
FAST = ("--speed", "0")


@pytest.fixture
def host(request):
    hosts = []

    def connect(address: str) -> TinyHost:
        hosts.append(TinyHost(address))
        return hosts[-1]

    yield connect
    for each in hosts:
        each.close()


def capture(host: TinyHost, seconds: float = SECONDS):
    _, describe = host.hello()
    data = host.sample(int(seconds * 256))
    return values(data, describe), data


@pytest.mark.parametrize("line", [("--pty",), ("--tcp", "0")])
def test_a_capture_is_the_testbeds_motion_seen_through_its_sensors(host, tmp_path, line):
    file = tmp_path / "truth.json"
    with running(*line, *FAST, "--releases", "-20", "--seed", "5", "--truth", str(file)) as address:
        (index, seen), data = capture(connected := host(address))
        assert connected.end.total_dropped == 0
        assert connected.end.checksum == crc32(b"".join(d.samples for d in data))
        truth = json.loads(file.read_text())
    np.testing.assert_array_equal(index, np.arange(len(index)))
    release = truth["releases"][0]
    assert release["from_m"] == -0.02
    moving = index > release["sample"] - 200  # Held still, then free.
    since = (index[moving] - release["sample"]) / 256.0
    bench = Bench(truth["stiffness_per_mass"], truth["mu_0"], truth["mu_1"])
    u, a = simulate_channels(
        bench, Release(-0.02, 0.0, release["hand_s"]), since - truth["displacement_late_s"], since
    )
    u += truth["offset_m"]
    a += truth["offset_m_s2"]
    # White noise to 1.5 % (2500 values) and the converter's step on top, up to 1 %: four of these.
    assert np.std(seen[moving, 0] - u) / truth["noise_m"] == pytest.approx(1.0, abs=0.07)
    assert np.std(seen[moving, 1] - a) / truth["noise_m_s2"] == pytest.approx(1.0, abs=0.07)
    assert abs(np.mean(seen[moving, 0] - u)) < 5.0 * truth["noise_m"] / 50.0


def test_the_program_samples_as_the_thread_does(host):
    arguments = ("--tcp", "0", *FAST, "--seed", "5")
    with running_double(*arguments) as address:
        (_, by_program), _ = capture(host(address), 1)
    with running(*arguments) as address:
        (_, by_thread), _ = capture(host(address), 1)
    np.testing.assert_array_equal(by_program[:256], by_thread[:256])


def test_a_sequence_goes_on_by_itself_and_from_capture_to_capture(host, tmp_path):
    file = tmp_path / "truth.json"
    with running(
        "--pty", *FAST, "--releases", "-25,20,v0.4", "--release-ms", "0", "--truth", str(file)
    ) as address:
        connected = host(address)
        capture(connected, 45)
        capture(connected, 12)
        capture(connected, 12)
        seen = json.loads(file.read_text())["releases"]
    by_capture = {
        key: [(r["from_m"], r["velocity_m_s"]) for r in group]
        for key, group in itertools.groupby(seen, lambda r: r["capture"])
    }
    assert [m for m, _ in by_capture[1][:2]] == [-0.025, 0.02]
    assert by_capture[1][2][1] == 0.4
    assert by_capture[2][0][0] == 0.02
    assert by_capture[3][0][1] == 0.4


def test_what_the_host_missed_is_sent_again(host):
    with running("--pty", *FAST) as address:
        connected = host(address)
        _, data = capture(connected, 5)
        again = connected.resend(300, 100)
    assert isinstance(again[-1], Ack)
    joined = b"".join(d.samples for d in data)[300 * 4 : 400 * 4]
    assert b"".join(m.samples for m in again if isinstance(m, Data)) == joined


def test_an_idle_board_beats_and_a_sampling_one_sends_ten_times_a_second(host):
    with running("--pty") as address:
        connected = host(address)
        connected.hello()
        connected.ask(Stop(), Heartbeat)
        data = connected.sample(64)
        assert max(d.n for d in data) <= 26  # a tenth of a second


@pytest.mark.parametrize("line", [("--pty",), ("--tcp", "0")])
def test_one_host_after_another_is_served(line):
    with running(*line, *FAST) as address:
        for _ in range(3):
            host = TinyHost(address)
            host.hello()
            host.sample(300)
            host.close()
            time.sleep(0.1)


def test_a_board_left_sampling_by_a_dead_host_can_be_stopped_by_the_next():
    with running("--pty") as address:
        first = TinyHost(address)
        first.hello()
        first.ask(Start(), Data)
        first.close()
        time.sleep(0.2)
        second = TinyHost(address)
        second.ask(HelloRequest(), Hello)
        second.ask(Stop(), Ack, End)
        second.close()


def test_a_hidden_effect_is_in_the_motion(host, tmp_path):
    file = tmp_path / "truth.json"
    with running(
        "--pty",
        *FAST,
        "--releases",
        "22",
        "--hide",
        "freeplay:0.02",
        "--release-ms",
        "0",
        "--truth",
        str(file),
    ) as address:
        (index, seen), _ = capture(host(address))
        truth = json.loads(file.read_text())
    assert truth["hidden"] == "freeplay"
    assert truth["strengths_reached"]["freeplay"] == pytest.approx(0.02, rel=2e-3)
    since = (index - truth["releases"][0]["sample"]) / 256.0
    effects = (Effect("freeplay", truth["parameters"]["freeplay"]),)
    plain = Bench(truth["stiffness_per_mass"], truth["mu_0"], truth["mu_1"])
    hiding = Bench(plain.stiffness, plain.mu_0, plain.mu_1, effects)
    for bench, fits in ((hiding, True), (plain, False)):
        late = since - truth["displacement_late_s"]
        u, _ = simulate_channels(bench, Release(0.022), late, since)
        error = np.std((seen[:, 0] - u)[since > -0.5]) / truth["noise_m"]
        assert (error < 1.07) == fits  # as above


@pytest.mark.parametrize(
    "name",
    ["offset_drift", "clipping", "ac_coupling", "mains_hum", "dropouts", "channel_lag", "channel_gain"],
)
def test_a_hidden_sensor_fault_is_in_its_channel_and_in_no_other(host, tmp_path, name):
    seen = {}
    for hidden in ((), ("--hide", f"{name}:0.03")):
        file = tmp_path / f"truth{len(hidden)}.json"
        with running("--pty", *FAST, "--releases", "22", *hidden, "--truth", str(file)) as address:
            seen[len(hidden)] = capture(host(address))[0][1][: 12 * 256]
    truth = json.loads(file.read_text())
    assert truth["kind"] == "sensor"
    at_fault = ("displacement", "acceleration").index(truth["parameters"][name]["channel"])
    difference = seen[2] - seen[0]
    noise = (truth["noise_m"], truth["noise_m_s2"])
    # The two runs share the bench and the noise (drop-outs draw more random numbers than a plain run).
    assert np.std(difference[:, at_fault]) > 3.0 * noise[at_fault]
    assert np.std(difference[:, 1 - at_fault]) < 1.5 * noise[1 - at_fault]


@pytest.mark.parametrize(
    "fault", ["lost", "flipped", "inserted", "duplicated", "reordered", "cut", "missing"]
)
def test_damage_on_the_wire_costs_frames_that_can_be_had_again(host, fault):
    amount = "0.05" if fault in {"cut", "missing"} else "0.001"
    with running("--pty", *FAST, "--fault", f"{fault}:{amount}", "--seed", "3") as address:
        connected = host(address)
        _, describe = connected.hello()
        data = connected.sample(10 * 256)
        index, _ = values(data, describe)
        missing = sorted(set(range(connected.end.total_samples)) - set(index.tolist()))
        assert missing
        sequences = [frame.sequence for frame in connected.frames]
        assert np.max(np.diff(sequences)) > 1
        got = {d.first_index + k: d.samples[4 * k : 4 * k + 4] for d in data for k in range(d.n)}
        for _ in range(20):
            if not missing:
                break
            for d in _ask_again(connected, missing):
                got |= {d.first_index + k: d.samples[4 * k : 4 * k + 4] for k in range(d.n)}
            missing = sorted(set(range(connected.end.total_samples)) - got.keys())
        assert not missing
        whole = b"".join(got[i] for i in range(connected.end.total_samples))
        assert crc32(whole) == connected.end.checksum


def _ask_again(host: TinyHost, missing: list[int]) -> list[Data]:
    """The wire may cost the answer itself: a TIMESYNC after the request ends the waiting."""
    host.send(Resend(missing[0], missing[-1] - missing[0] + 1))
    before = len(host.frames)
    host.ask(TimeSync(1, 0), TimeSync)
    return [f.message for f in host.frames[before:] if isinstance(f.message, Data)]


def test_a_pulled_cable_is_the_error_of_a_pulled_adapter(host):
    with running("--pty", *FAST, "--fault", "unplug@4") as address:
        connected = host(address)
        connected.hello()
        with pytest.raises(OSError, match=r".*"):
            connected.sample(10 * 256)


def test_after_a_pulled_cable_a_tcp_board_can_be_met_again(host):
    with running("--tcp", "0", *FAST, "--fault", "unplug@4") as address:
        first = host(address)
        first.hello()
        with pytest.raises(OSError, match=r".*"):
            first.sample(10 * 256)
        host(address).hello()


def test_after_a_stall_all_goes_on_and_nothing_is_lost(host):
    with running("--pty", "--speed", "8", "--fault", "stall:0.5@1") as address:
        connected = host(address)
        connected.hello()
        data = connected.sample(4 * 256)
        assert [d.first_index for d in data[1:]] == [d.first_index + d.n for d in data[:-1]]
        assert connected.end.total_dropped == 0


def test_a_reboot_in_mid_capture_shows_in_the_boot_id(host):
    with running("--pty", *FAST, "--fault", "reboot@4") as address:
        connected = host(address)
        before, _ = connected.hello()
        with pytest.raises(AssertionError, match="no END"):
            connected.sample(10 * 256, seconds=1.5)
        after, _ = connected.hello()
        assert after.boot_id != before.boot_id
        capture(connected, 6)  # It reboots once.


@pytest.mark.slow
def test_a_slow_line_makes_the_board_drop_and_say_so(host):
    with running("--pty", "--speed", "8", "--fault", "slow:2500") as address:
        connected = host(address)
        connected.hello()
        (overrun,) = connected.ask(Start(), Event, seconds=20.0)
        assert overrun.kind is EventKind.OVERRUN
        assert overrun.count > 0


def test_a_board_of_another_version_says_so(host):
    with running("--pty", "--fault", "wrong-version") as address:
        connected = host(address)
        connected.ask(HelloRequest(), OtherVersion)


def test_a_saturated_accelerometer_stops_at_its_range_and_says_so(host):
    with running("--pty", *FAST, "--releases", "25", "--fault", "saturation") as address:
        connected = host(address)
        _, describe = connected.hello()
        data = connected.sample(10 * 256)
        _, seen = values(data, describe)
        low, high = describe.channels[1].low, describe.channels[1].high
        assert high - low == pytest.approx(16.0, rel=1e-3)
        assert seen[:, 1].min() == pytest.approx(low)
        assert seen[:, 1].max() == pytest.approx(high)
        events = [f.message for f in connected.frames if isinstance(f.message, Event)]
        assert {event.kind for event in events} == {EventKind.SATURATION}


def test_a_bump_of_the_table_comes_before_the_release(host, tmp_path):
    file = tmp_path / "truth.json"
    with running("--pty", *FAST, "--releases", "20", "--fault", "bump", "--truth", str(file)) as address:
        (index, seen), _ = capture(host(address))
        released = json.loads(file.read_text())["releases"][0]["sample"]
    before = index < released - 20
    assert 0.5 < np.max(np.abs(seen[before, 1])) < 1.5


def test_the_double_ends_at_a_signal_with_code_0():
    command = [sys.executable, "-m", "mocks", "--tcp", "0"]
    options = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, cwd=ROOT, **options) as process:
        assert process.stdout.readline().startswith("port: ")
        process.send_signal(signal.SIGTERM)
    assert process.returncode == 0


def test_a_double_for_one_host_ends_with_it():
    def serving() -> bool:
        return any(thread.name == "bench double" for thread in threading.enumerate())

    with running("--tcp", "0", "--once") as address:
        assert serving()
        host = TinyHost(address)
        host.hello()
        host.close()
        for thread in threading.enumerate():
            if thread.name == "bench double":
                thread.join(timeout=10.0)
        assert not serving()


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("--pty", "--hide", "gremlin:0.1"), "no effect is called 'gremlin'"),
        (("--pty", "--hide", "freeplay:much"), "is written NAME:STRENGTH"),
        (("--pty", "--fault", "gremlin"), "no fault is called 'gremlin'"),
        (("--pty", "--releases", "far"), "not 'far'"),
        ((), "one of the arguments --pty --tcp is required"),
    ],
)
def test_a_wrong_command_line_is_refused_in_words(capsys, arguments, complaint):
    with pytest.raises(SystemExit) as refused:
        main(list(arguments))
    assert refused.value.code == 2
    assert complaint in capsys.readouterr().err
