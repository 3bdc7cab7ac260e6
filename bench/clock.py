"""`python -m bench.clock PORT [SECONDS]`: the clock of a board against this computer's, to some 50 ppm in ten minutes."""

import sys
import time

from daq.link import Link
from daq.port import open_port
from firmware_protocol import TimeSync


def board_s(link: Link) -> float:
    """Ask the board for its clock, in s."""
    link.send(TimeSync(0))
    return link.wait(lambda message: isinstance(message, TimeSync), 1.0).message.board_time_us / 1e6


def main(port: str, seconds: float = 600.0) -> None:
    """Print the frequency of the board's clock in Hz, as `CLOCK_HZ` wants it."""
    with Link(open_port(port)) as link:
        clock_hz = link.handshake().clock_hz
        began, board_began = time.monotonic(), board_s(link)
        while time.monotonic() < began + seconds:
            link.take(0.5)
        print(round(clock_hz * (board_s(link) - board_began) / (time.monotonic() - began)))


if __name__ == "__main__":
    main(sys.argv[1], *map(float, sys.argv[2:]))
