"""A short sample of a board: handshake, some seconds of data, nothing written, every wait bounded."""

from dataclasses import dataclass

from daq.capture_stream import CaptureStream
from daq.clock import ClockFit
from daq.link import GIVE_UP_S, Link
from daq.observer import CaptureObserver
from daq.port import open_port
from daq.recording import Recording
from firmware_protocol import Hello


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
