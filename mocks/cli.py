"""The command line of the bench's double: `python -m mocks --pty` or `--tcp PORT`."""

from __future__ import annotations

import argparse
import os
import select
import signal
import stat
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from mocks import faults as wire, generate
from mocks.broken_sensors import BROKEN_SENSORS
from mocks.link import Link, PtyLink, TcpLink
from mocks.misconfigurations import MISCONFIGURATIONS
from mocks.serve import serve
from mocks.simulated_board import SimulatedBoard


def main(argv: list[str] | None = None) -> int:
    """Run the double; the exit code is 0, or 2 for a wrong command line."""
    options = parse(sys.argv[1:] if argv is None else argv)
    try:
        simulated = SimulatedBoard(options)
    except ValueError as error:
        parser().error(str(error))
    ended = _ending()
    try:
        link = open_link(options)
    except (OSError, OverflowError) as error:
        reason = os.strerror(error.errno) if isinstance(error, OSError) and error.errno else str(error)
        parser().error(
            f"port {options.tcp} cannot be opened ({reason}); name another one, or 0 for a free one"
        )
    try:
        simulated.write_truth()
        print(f"port: {link.address}", flush=True)
        serve(link, simulated.board, simulated.line, options.speed, options.once, ended)
    finally:
        link.close()
    return 0


def parse(words: Sequence[str]) -> argparse.Namespace:
    """Return the options of a command line; SystemExit with words on stderr for a wrong one."""
    return parser().parse_args(_joined(words))


def open_link(options: argparse.Namespace) -> Link:
    """Return the board's end of the line that the options name; OSError where the port is taken."""
    return PtyLink() if options.pty else TcpLink(options.tcp)


def _joined(words: Sequence[str]) -> list[str]:
    """Join `--releases -25,20` to one word: argparse takes the minus for an option."""
    out: list[str] = []
    for word in words:
        if out and out[-1] in {"--releases", "--lag-ms", "--holder"}:
            out[-1] += f"={word}"
        else:
            out.append(word)
    return out


def parser() -> argparse.ArgumentParser:
    """Return the parser of the options that a `SimulatedBoard` is built from."""
    parser = argparse.ArgumentParser(
        prog="python -m mocks",
        description="The bench's double: a simulated testbed behind a board that speaks the real protocol.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=_names(),
    )
    line = parser.add_mutually_exclusive_group(required=True)
    line.add_argument("--pty", action="store_true", help="on a pseudo terminal")
    line.add_argument("--tcp", type=int, metavar="PORT", help="on a TCP port of this machine; 0: a free one")
    parser.add_argument(
        "--speed", type=float, default=1.0, help="times real time; 0: as fast as the reader takes"
    )
    parser.add_argument(
        "--releases", default="", help="paper, or a list of mm (-25,20) and velocities (v0.4, m/s)"
    )
    parser.add_argument(
        "--holder",
        metavar="LOW,HIGH",
        help="the rig holds and releases the mass itself, between these displacements in mm (-25,25); nobody else does",
    )
    parser.add_argument("--hide", action="append", default=[], metavar="NAME:STRENGTH", help="hide an effect")
    parser.add_argument("--seed", type=int, default=1, help="of bench, sensors, release, noise and faults")
    parser.add_argument("--lag-ms", type=float, help="how late the displacement is; else drawn, ±3 ms")
    parser.add_argument("--release-ms", type=float, help="how long letting go takes; else drawn")
    parser.add_argument("--fault", action="append", default=[], metavar="NAME[:AMOUNT]", help="see below")
    parser.add_argument("--memory-s", type=float, help="seconds of samples kept for RESEND; else 12")
    parser.add_argument("--truth", type=Path, metavar="FILE", help="write what is simulated, JSON")
    parser.add_argument("--once", action="store_true", help="end when the first host has gone")
    return parser


def _names() -> str:
    lines = ["effects:"]
    lines += [f"  {name}" for name in generate.everything()]
    lines += ["faults of the line, NAME[:AMOUNT][@SECONDS SAMPLED]:"]
    table = wire.PER_BYTE | wire.PER_FRAME | wire.LASTING | wire.ONCE
    lines += [f"  {name:<14}{amount:<8g}{what}" for name, (amount, what) in table.items()]
    lines += ["faults of the board, NAME[:AMOUNT]:"]
    lines += [f"  {name:<14}{what}" for name, what in MISCONFIGURATIONS.items()]
    lines += ["sensors that break, NAME[:AMOUNT[:CHANNEL]]:"]
    lines += [f"  {name:<14}{amount:<8g}{what}" for name, (amount, what) in BROKEN_SENSORS.items()]
    return "\n".join(lines)


def _ending() -> Callable[[], bool]:
    """Return a question: has SIGTERM or SIGINT come, or the pipe on stdin been closed?"""
    stop: list[int] = []
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda got, _: stop.append(got))
    try:
        piped = stat.S_ISFIFO(os.fstat(sys.stdin.fileno()).st_mode)
    except (OSError, ValueError, AttributeError):
        piped = False

    def ended() -> bool:
        if piped and select.select([sys.stdin], [], [], 0)[0] and not os.read(sys.stdin.fileno(), 4096):
            stop.append(0)
        return bool(stop)

    return ended
