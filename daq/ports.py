"""What can be learnt of ports: which there are, what the system knows of one, who answers there, and what a board sends.

A port must be named unless exactly one answers.
"""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from daq.capture_stream import CaptureObserver, CaptureStream
from daq.clock import ClockFit
from daq.errors import BoardError, PortError, StationError
from daq.link import GIVE_UP_S, Link
from daq.port import Port, PortDescription, open_port, system_ports
from daq.recording import Channel, Recording
from firmware_protocol import Hello

PROBE_S = 2.5
MOST_PROBED = 16
PROC = Path("/proc")
SYSTEM_TTY = Path("/sys/class/tty")


@dataclass(frozen=True)
class Candidate:
    """A port, and what answered there: `hello` and `channels`, or `problem` in words.

    `answers` is true for a board of this protocol, whatever its version.
    """

    port: PortDescription
    hello: Hello | None = None
    channels: tuple[Channel, ...] = ()
    problem: str = ""
    answers: bool = False


def probe(
    description: PortDescription, seconds: float = PROBE_S, opener: Callable[[str], Port] = open_port
) -> Candidate:
    """Ask HELLO at one port, for at most `seconds`; never raises for what is found there."""
    try:
        with Link(opener(description.name)) as link:
            hello = link.handshake(seconds)
            return Candidate(description, hello, link.assembly.channels, answers=True)
    except StationError as error:
        return Candidate(description, problem=str(error), answers=isinstance(error, BoardError))


def list_ports(
    names: Iterable[str] = (), seconds: float = PROBE_S, opener: Callable[[str], Port] = open_port
) -> tuple[Candidate, ...]:
    """Probe the computer's serial ports and the named ones, all at once; those that answer come first."""
    known = {port.name: port for port in system_ports()}
    known |= {name: PortDescription(name) for name in names if name not in known}
    ports = list(known.values())[:MOST_PROBED]
    if not ports:
        return ()
    with ThreadPoolExecutor(len(ports)) as pool:
        found = list(pool.map(lambda port: probe(port, seconds, opener), ports))
    return tuple(sorted(found, key=lambda candidate: not candidate.answers))


def choose_port(name: str | None, candidates: Callable[[], tuple[Candidate, ...]] = list_ports) -> str:
    """Return `name`, or without one the only port that answers; PortError where none does, or several."""
    if name:
        return name
    found = candidates()
    answering = [candidate.port.name for candidate in found if candidate.answers]
    if len(answering) == 1:
        return answering[0]
    if answering:
        raise PortError(f"{len(answering)} boards answer ({', '.join(answering)}); name one of them")
    if not found:
        raise PortError("this computer has no serial port; plug the board in, or name a port")
    names = ", ".join(candidate.port.name for candidate in found[:5])
    raise PortError(f"no board answers at {names}; plug it in, or name its port")


@dataclass(frozen=True)
class BoardSample:
    """Who answered, what came, the rate by this computer's clock, and damaged frames."""

    hello: Hello
    recording: Recording
    clock: ClockFit | None
    damaged: int


def sample_board(port: str, seconds: float, rate_hz: float) -> BoardSample:
    """Sample the board at `port` for so many seconds of its own time, at `rate_hz` (0: its own rate).

    Raises a StationError as a capture does; LinkLost after 2 s without samples.
    """
    with Link(open_port(port)) as link:
        hello = link.handshake()
        link.configure(rate_hz)
        assembly = link.assembly
        stream = CaptureStream(link, CaptureObserver(), kept="nothing was kept")
        stream.start()
        stream.take_to(round(seconds * assembly.rate), 2 * seconds + GIVE_UP_S)
        link.stop()
        return BoardSample(
            hello, assembly.recording(), assembly.samples.host_clock(), link.statistics.damaged
        )


def holders(name: str, proc: Path = PROC) -> tuple[tuple[str, int], ...]:
    """Return the programs (name, pid) that have a port open, none of a URL: what /proc/PID/fd (Linux) shows this user.

    Other users' programs stay unseen without their rights.
    """
    device, found = os.path.realpath(name), []
    for process in sorted(proc.glob("[0-9]*")):
        pid = int(process.name)
        with suppress(OSError):
            opened = any(os.path.realpath(entry) == device for entry in (process / "fd").iterdir())
            if opened and pid != os.getpid():
                found.append(((process / "comm").read_text(errors="replace").strip(), pid))
    return tuple(found)


def latency_ms(name: str, tty: Path = SYSTEM_TTY) -> int | None:
    """Return the latency of an FTDI adapter (ms), None where the system does not know it, as of a URL."""
    if "://" in name:
        return None
    try:
        return int((tty / Path(os.path.realpath(name)).name / "device" / "latency_timer").read_text())
    except (OSError, ValueError):
        return None
