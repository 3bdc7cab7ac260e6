"""The images run: `station capture` records a release from each emulated board, whatever befalls it."""

import json
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Protocol

import pytest
from conftest import or_skip
from fault_bench import Promise, broken_promises, promises, station_capture

from bench.emulated import boards, images, motion
from bench.emulated.boards import Board
from daq.link import Link
from daq.port import open_port
from firmware_protocol import EventKind

BOOT_LOADER = Path("/usr/share/arduino/hardware/arduino/avr/bootloaders/stk500v2/stk500boot_v2_mega2560.hex")
pytestmark = pytest.mark.usefixtures("unrendered")
RATE_HZ = 256.0
# Seconds of sampling after which the release is being recorded.
LATER = motion.REST_S + 3.0


class Run(Protocol):
    """Start one of the two boards."""

    def __call__(self, befalls: tuple[float, str] | None = None) -> AbstractContextManager[Board]: ...


@pytest.fixture(params=["mega", "launchpad"])
def run(request: pytest.FixtureRequest, tmp_path: Path) -> Run:
    image = request.getfixturevalue(f"{request.param}_image")
    start = getattr(boards, request.param)
    if request.param == "mega":
        or_skip(images.simavr_board, tmp_path / "simavr_board")
    else:
        or_skip(images.need, "qemu-system-arm")

    def started(befalls: tuple[float, str] | None = None) -> AbstractContextManager[Board]:
        return start(tmp_path, image, befalls=befalls)  # type: ignore[no-any-return]

    return started


def promised(fault: str) -> Promise:
    return next(row for row in promises() if row.fault == fault)


@pytest.mark.slow
def test_a_release_is_recorded_and_identified_though_the_wire_lost_frames(run: Run, tmp_path: Path) -> None:
    with run(befalls=(LATER, "lose 300")) as board:
        done = station_capture(board.port, tmp_path / "s", "--mass", "21.36")
    assert not broken_promises(promised("lost bytes"), done), done.said
    assert done.session is not None
    assert done.session.manifest().counts.resent > 0, "nothing was lost, so nothing was asked for again"
    found = json.loads((done.session.folder / "results" / "identification.json").read_text("utf-8"))
    assert (found["record"]["samples"], found["record"]["lost_samples"]) == (9 * RATE_HZ, 0)
    bench = motion.BENCH
    for method in ("wavelet", "restoring_force"):
        dry, viscous = found[method]["damping"]
        for value, truth in (
            (found[method]["stiffness_per_mass"], bench.stiffness),
            (dry, bench.mu_0),
            (viscous, bench.mu_1),
        ):
            # Five of its own standard errors: six figures, two boards, one seed each.
            assert abs(value["value"] - truth) < 5 * value["std"], (method, value, truth)
    # A first-order low-pass is late by atan(w RC) / w at the oscillation's frequency, 3.193 ms; the decay's
    # harmonics and the order of the readings are worth 0.05 ms.
    assert found["alignment"]["lag_s"]["value"] == pytest.approx(-3.19e-3, abs=0.06e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("run", "fault", "what"),
    [("mega", "reboot in mid-capture", "reset"), ("launchpad", "unplug", "die")],
    indirect=["run"],
    ids=["reset", "unplug"],
)
def test_a_fault_ends_as_the_page_promises(run: Run, tmp_path: Path, fault: str, what: str) -> None:
    with run(befalls=(LATER - 1, what)) as board:
        done = station_capture(board.port, tmp_path / "s", "--duration", "3")
    assert not broken_promises(promised(fault), done), done.said


@pytest.mark.slow
def test_a_mega_that_opening_the_port_has_reset_gets_past_its_boot_loader(
    mega_image: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Asked at once, it never answers: the boot loader waits for the end of what it takes for a program."""
    if not BOOT_LOADER.exists():
        pytest.skip("the Arduino's boot loader is not on this machine (Debian: arduino-core-avr)")
    or_skip(images.simavr_board, tmp_path / "simavr_board")
    monkeypatch.setattr("daq.link.may_have_reset_the_board", lambda port: True)  # as no pty does
    with (
        boards.mega(tmp_path, mega_image, options=("--boot-loader", str(BOOT_LOADER))) as board,
        Link(open_port(board.port)) as link,
    ):
        assert link.handshake().board == "Arduino Mega 2560"


@pytest.mark.slow
def test_the_board_reports_its_clock_its_jitter_and_what_it_missed(run: Run) -> None:
    with run() as board, Link(open_port(board.port)) as link:
        hello = link.handshake()
        link.configure(RATE_HZ)
        link.start()
        link.wait(lambda message: False, 1.0)
        link.stop()
        events = [event for event in link.assembly.events if event.kind is EventKind.OTHER]
        end, clock_ppm = link.assembly.end, link.assembly.clock_ppm
    # Of a ceramic resonator and of a crystal; the Mega makes the 64 bits on the wire of its own 32.
    assert clock_ppm == (5000.0 if "Mega" in hello.board else 50.0)
    assert end is not None
    assert end.total_dropped == 0
    assert len(events) == 1
    assert events[0].text.endswith(f"; 0 of {end.total_samples} missed")
    assert "us late, jitter" in events[0].text
