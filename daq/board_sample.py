"""A short sample of a board: handshake, some seconds of data, nothing written, every wait bounded."""

import time
from dataclasses import dataclass

from daq.clock import ClockFit
from daq.errors import ProtocolError, Stalled
from daq.link import GIVE_UP_S, Link
from daq.port import open_port
from daq.recording import Recording
from firmware_protocol import Hello


@dataclass(frozen=True)
class BoardSample:
    """Who answered, what came, the rate by this computer's clock, damaged frames, and what contradicts the protocol."""

    hello: Hello
    recording: Recording
    clock: ClockFit | None
    damaged: int
    contradictions: tuple[str, ...]


def sample_board(port: str, seconds: float, rate_hz: float = 0.0) -> BoardSample:
    """Sample the board at `port` for so many seconds of its own time, at `rate_hz` (0: its own rate).

    Raises a StationError as a capture does; Stalled after 2 s without samples.
    """
    with Link(open_port(port)) as link:
        hello = link.handshake()
        link.configure(rate_hz)
        link.start()
        _take(link, seconds)
        link.stop()
        assembly = link.assembly
        return BoardSample(
            hello,
            assembly.recording(),
            assembly.samples.host_clock(),
            link.statistics.damaged,
            tuple(assembly.contradictions),
        )


def _take(link: Link, seconds: float) -> None:
    assembly = link.assembly
    until, last, before = time.monotonic() + 2 * seconds + GIVE_UP_S, time.monotonic(), 0
    while assembly.expected < seconds * assembly.rate and time.monotonic() < until:
        link.take(0.05)
        if assembly.contradictions:
            raise ProtocolError(f"{assembly.contradictions[-1]}; its firmware needs a correction")
        if assembly.expected > before:
            last, before = time.monotonic(), assembly.expected
        if time.monotonic() - last > GIVE_UP_S:
            raise Stalled(
                f"{link.port.name}: the board sent no samples for {GIVE_UP_S:g} s; reset it, check the cable"
            )
