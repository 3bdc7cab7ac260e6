"""The reference firmware on both emulated boards: what it takes, how evenly it samples, what it loses at which rate."""

import re
import tempfile
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from bench.emulated import boards, images
from bench.emulated.boards import Board
from daq.link import Link
from daq.port import open_port
from firmware_protocol import End, EventKind, Start

TITLE = "Firmware on emulated boards"
RATES_HZ = (256.0, 2000.0)
LINE_BYTES_PER_S = 115200 / 10
JITTER = re.compile(r"jitter ([\d.]+) us; (\d+) of (\d+) missed")
# One instruction takes 32 ns of the emulated time, two thirds of what a Cortex-M3 needs at 50 MHz; idle time is skipped.
BY_INSTRUCTIONS = ("-icount", "shift=5,sleep=off")

Started = Callable[[], AbstractContextManager[Board]]


@dataclass(frozen=True)
class Captured:
    """One capture: samples, of these dropped by the board and lost on the wire; its report; bytes sent a second."""

    samples: int
    dropped: int
    lost: int
    missed: int
    jitter_us: float
    bytes_per_s: float


def capture(started: Started, rate_hz: float, seconds: float) -> tuple[Captured, Board]:
    """Let a board take so many seconds of samples and end by itself."""
    with started() as board, Link(open_port(board.port)) as link:
        link.handshake()
        link.configure(rate_hz)
        link.assembly.events.clear()
        before = link.statistics.bytes
        link.assembly.end = None
        count = round(rate_hz * seconds)
        link.log.note(event="start")
        link.assembly.take_note({"event": "start"})
        link.request(Start(count))
        if link.wait(lambda message: isinstance(message, End), 4 * seconds + 20) is None:
            raise AssertionError("the capture did not end")
        sent = link.statistics.bytes - before
        recording = link.assembly.recording()
        end, events = link.assembly.end, link.assembly.events
    assert end is not None
    report = JITTER.search(next(event.text for event in events if event.kind is EventKind.OTHER))
    assert report is not None
    lost = sum(gap.count for gap in recording.gaps if gap.reason == "wire")
    found = Captured(
        end.total_samples, end.total_dropped, lost, int(report[2]), float(report[1]), sent / seconds
    )
    return found, board


def mega_rows(folder: Path, seconds: float) -> list[str]:
    """Capture at each rate from the Mega's image in simavr."""
    image = images.mega(folder / "mega.elf")
    rows = []
    for rate in RATES_HZ:
        found, _ = capture(partial(boards.mega, folder, image), rate, seconds)
        rows.append(_row("Arduino Mega", rate, found, found.jitter_us))
    return rows


def launchpad_rows(folder: Path, seconds: float) -> list[str]:
    """Capture at each rate from the Cortex-M3's image in QEMU; its jitter by instructions, not by this computer."""
    image = images.launchpad(folder / "launchpad.elf", *images.EMULATED)
    rows = []
    for rate in RATES_HZ:
        run = partial(boards.launchpad, folder, image, rate_hz=rate)
        found, _ = capture(run, rate, seconds)
        alone, _ = capture(partial(run, options=BY_INSTRUCTIONS), rate, seconds)
        rows.append(_row("LM3S6965", rate, found, alone.jitter_us))
    return rows


def _row(name: str, rate: float, found: Captured, jitter_us: float) -> str:
    share = found.bytes_per_s / LINE_BYTES_PER_S
    return (
        f"| {name} | {rate:.0f} | {found.missed}/{found.dropped - found.missed}/{found.lost} of {found.samples} | "
        f"{jitter_us:.1f} | {100 * share:.0f} % |"
    )


def run(quick: bool) -> str:
    """Return the section of the benchmark page."""
    seconds = 2.0 if quick else 10.0
    with tempfile.TemporaryDirectory() as folder:
        rows = mega_rows(Path(folder), seconds) + launchpad_rows(Path(folder), seconds)
    return "\n".join(
        [
            "| board | rate, Hz | missed/overrun/lost on the wire | jitter, us | of 115200 baud |",
            "|---|---:|---:|---:|---:|",
            *rows,
            "",
            "Two channels of 16 bits; the Mega in simavr, the LM3S6965 in QEMU. Missed: not read in time. "
            "Jitter: latest less earliest start of a sample.",
        ]
    )


if __name__ == "__main__":
    print(run(quick=True))
