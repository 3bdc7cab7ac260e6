"""The images running: a port to open, and what befalls the board while it samples."""

import contextlib
import json
import socket
import subprocess
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bench.emulated import images, motion
from bench.emulated.relay import Relay

NOISE_MV = 2.0  # of each reading of the Mega's; of the LaunchPad's mean of 16 readings, half of it
READY_S = 30.0
QEMU = ("qemu-system-arm", "-M", "lm3s6965evb", "-display", "none", "-monitor", "stdio")


@dataclass
class Board:
    """A running board: its port, and after its end what the emulator has measured."""

    port: str
    measured: dict[str, Any] = field(default_factory=dict)


@contextlib.contextmanager
def mega(
    folder: Path,
    image: Path,
    *,
    mcu: str = "atmega2560",
    befalls: tuple[float, str] | None = None,
    options: tuple[str, ...] = (),
) -> Iterator[Board]:
    """Run an AVR image in simavr; `befalls`: (seconds of sampling, `reset`, `lose N` or `die`)."""
    program, volts = folder / "simavr_board", folder / "volts.f32"
    if not program.exists():
        images.simavr_board(program)
    if not volts.exists():
        motion.write_volts(volts)
    pins = ("--volts", volts, "--file-hz", str(motion.FILE_HZ), "--noise-mv", str(NOISE_MV), "--seed", "1")
    at = ("--at", f"{befalls[0]} {befalls[1]}") if befalls else ()
    process = subprocess.Popen(
        [program, image, mcu, *pins, *at, *options],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    port = next(line for line in process.stdout if line.startswith("port: ")).removeprefix("port: ").strip()
    board = Board(port)
    try:
        yield board
    finally:
        said, _ = process.communicate(timeout=20)
        if process.returncode:
            raise AssertionError(f"simavr ended with {process.returncode}")
        if said.strip():
            board.measured.update(json.loads(said))


@contextlib.contextmanager
def launchpad(
    folder: Path,
    image: Path,
    *,
    rate_hz: float = 256.0,
    befalls: tuple[float, str] | None = None,
    options: tuple[str, ...] = (),
) -> Iterator[Board]:
    """Run a Cortex-M image in QEMU, its port behind a relay; `befalls` as for `mega`."""
    images.need("qemu-system-arm")
    motion.readings(rate_hz, NOISE_MV / 2, seed=1).tofile(folder / "converter.bin")
    number = _free_port()
    serial = ("-serial", f"tcp:127.0.0.1:{number},server=on,wait=off")
    converter = ("-semihosting-config", "enable=on,target=native")
    process = subprocess.Popen(
        [*QEMU, "-kernel", image, *serial, *converter, *options],
        cwd=folder,
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    assert process.stdin is not None
    monitor = process.stdin

    def befall(relay: Relay) -> None:
        what = befalls[1] if befalls else ""
        if what == "reset":
            monitor.write("system_reset\n")
            monitor.flush()
        elif what == "die":
            relay.close()
        else:
            relay.to_lose = int(what.removeprefix("lose "))

    _wait_for(number)
    relay = Relay(number, befalls[0], befall) if befalls else Relay(number)
    try:
        yield Board(relay.address)
    finally:
        relay.close()
        process.kill()
        process.communicate(timeout=20)
        relay.join()


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return int(server.getsockname()[1])


def _wait_for(number: int) -> None:
    until = time.monotonic() + READY_S
    while time.monotonic() < until:
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", number), timeout=1):
            return
        time.sleep(0.05)
    raise AssertionError("QEMU did not start")
