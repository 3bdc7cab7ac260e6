"""The command line of the bench's double: `python -m mocks --pty` or `--tcp PORT`."""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import select
import signal
import stat
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from firmware_protocol import ChannelDescription
from mocks import faults as wire
from mocks import generate
from mocks.acquisition import Acquisition, Converter
from mocks.bench_run import BenchRun, Episode, parse_releases
from mocks.board import Board
from mocks.forces import PARAMETERS
from mocks.hiding import hide
from mocks.lies import Lies
from mocks.link import Link, PtyLink, TcpLink
from mocks.sensor_faults import SENSOR_FAULTS
from mocks.serve import serve
from mocks.setting import draw_hand, draw_setting
from mocks.testbed import Release, simulate

LIES = {
    "wrong-version": "speaks major version 2",
    "rate-lie": "samples 1 % (or AMOUNT) faster than described",
    "describe-lie": "describes a format and a channel that DATA does not have",
    "counter-lie": "indices jump by 7, the checksum of END is wrong",
    "clock-200ppm": "the board's clock is 200 ppm (or AMOUNT) fast",
    "saturation": "accelerometer with a range of 8 m/s^2 (or AMOUNT)",
    "dead-channel": "channel 1 (or AMOUNT) reads nothing but zero",
    "swapped": "the two sensors are wired to each other's input",
    "reversed": "the accelerometer is mounted the wrong way round",
    "bump": "somebody bumps the table while the mass is held",
}
#: Offsets that calibration has found and DESCRIBE tells, m and m/s^2.
CALIBRATION = (4e-4, -0.25)


def main(argv: list[str] | None = None) -> int:
    """Run the double; the exit code is 0, or 2 for a wrong command line."""
    parser = _parser()
    options = parser.parse_args(_joined(sys.argv[1:] if argv is None else argv))
    try:
        bench = _Day(options)
    except ValueError as error:
        parser.error(str(error))
    link: Link = PtyLink() if options.pty else TcpLink(options.tcp)
    try:
        bench.write_truth()
        print(f"port: {link.address}", flush=True)
        serve(link, bench.board, bench.line, options.speed, options.once, _ending())
    finally:
        link.close()
    return 0


def _joined(words: list[str]) -> list[str]:
    """Join `--releases -25,20` to one word: argparse takes the minus for an option."""
    out: list[str] = []
    for word in words:
        if out and out[-1] in {"--releases", "--lag-ms"}:
            out[-1] += f"={word}"
        else:
            out.append(word)
    return out


def _parser() -> argparse.ArgumentParser:
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
    parser.add_argument("--hide", action="append", default=[], metavar="NAME:STRENGTH", help="hide an effect")
    parser.add_argument("--seed", type=int, default=1, help="of bench, sensors, hand, noise and faults")
    parser.add_argument("--lag-ms", type=float, help="how late the displacement is; else drawn, +-3 ms")
    parser.add_argument("--hand-ms", type=float, help="how long the hand takes to let go; else drawn")
    parser.add_argument("--fault", action="append", default=[], metavar="NAME[:AMOUNT]", help="see below")
    parser.add_argument("--memory-s", type=float, help="seconds of samples kept for RESEND; else 8")
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
    lines += [f"  {name:<14}{what}" for name, what in LIES.items()]
    return "\n".join(lines)


class _Day:
    """Everything that a command line asks for, drawn and built."""

    def __init__(self, options: argparse.Namespace) -> None:
        self._options = options
        self._random = np.random.default_rng([options.seed, 7])
        self._releases_seen: list[dict[str, Any]] = []
        self._captures = 0
        fixed: dict[str, float] = {}
        if options.lag_ms is not None:
            fixed["lag"] = options.lag_ms * 1e-3
        if options.hand_ms is not None:
            fixed["hand"] = options.hand_ms * 1e-3
        self.lies, bumped, line_faults, fixed_range = _sort_faults(options.fault, self._random)
        self.setting = draw_setting(options.seed, fixed | fixed_range)
        releases = parse_releases(
            options.releases or f"{self.setting.amplitude * 1e3:.6f}", self._hands(options)
        )
        strengths = dict(_strength(text) for text in options.hide)
        self._hide(strengths, releases)
        self.run = BenchRun(self.bench, releases, bumped)
        simulate(self.bench, releases[0], np.arange(0.0, 0.1, 0.01))  # Compiles before a host waits.
        self.line = wire.Line(line_faults, np.random.default_rng([options.seed, 8]))
        self._sensors = self.setting.sensors
        self._converters = tuple(
            Converter(2.0 * limit / 2.0**self.setting.bits, offset, self.setting.bits)
            for limit, offset in zip(
                (self.setting.range_displacement, self.setting.range_acceleration), CALIBRATION, strict=True
            )
        )
        memory = options.memory_s or (8.0 * max(1.0, options.speed) if options.speed else 600.0)
        import time

        self.board = Board(
            self._channels(), self._source, self._random, time.monotonic(), options.speed, self.lies, memory
        )

    def _hands(self, options: argparse.Namespace) -> Iterator[float]:
        random = np.random.default_rng([options.seed, 9])
        while True:
            drawn = draw_hand(random)
            yield self.setting.hand if options.hand_ms is not None else drawn

    def _hide(self, strengths: dict[str, float], releases: tuple[Release, ...]) -> None:
        """Fix the size of everything hidden on the largest release of the sequence."""
        plain = self.setting.bench
        largest = max(
            releases, key=lambda r: max(abs(r.displacement), abs(r.velocity) / plain.angular_frequency)
        )
        physics = {n: s for n, s in strengths.items() if n in PARAMETERS}
        self.bench, reached = hide(plain, largest, physics, self._options.seed)
        sensor = {n: s for n, s in strengths.items() if n in SENSOR_FAULTS}
        reference = dataclasses.replace(
            self.setting, amplitude=largest.displacement, velocity=largest.velocity, hand=largest.hand
        )
        found = generate.find_faults(self.bench, reference, sensor, self._options.seed, {})[1]
        if "dropouts" in sensor:
            found["dropouts"] = generate.find_dropouts(
                self.bench, reference, sensor["dropouts"], self._options.seed
            )
        self.faults = {name: parameters for name, (parameters, _) in found.items()}
        if "channel_lag" in self.faults:
            late = self.setting.lag + self.faults["channel_lag"]["lag"]
            self.setting = dataclasses.replace(self.setting, lag=late)
        self.reached = reached | {name: strength for name, (_, strength) in found.items()}
        self.strengths = strengths

    def _source(self, rate: float) -> Acquisition:
        self._captures += 1
        capture = self._captures

        def released(episode: Episode, sample: float) -> None:
            assert episode.release is not None
            if all(entry["capture"] != capture for entry in self._releases_seen):
                self.run.use_up(episode)
            self._releases_seen.append(
                {
                    "capture": capture,
                    "sample": sample,
                    "from_m": episode.release.displacement,
                    "velocity_m_s": episode.release.velocity,
                    "hand_s": episode.release.hand,
                }
            )
            self.write_truth()

        return Acquisition(
            self.bench,
            self.run.capture(self._random),
            rate,
            (self._sensors["displacement"], self._sensors["acceleration"]),
            (self._converters[0], self._converters[1]),
            self.faults,
            self._random,
            released,
        )

    def _channels(self) -> tuple[ChannelDescription, ...]:
        about = (
            ("displacement", "m", "Simulated LVDT"),
            ("acceleration", "m/s^2", "Simulated accelerometer"),
        )
        half = 2 ** (self.setting.bits - 1)
        return tuple(
            ChannelDescription(
                name=quantity,
                quantity=quantity,
                unit=unit,
                scale=c.scale,
                offset=c.offset,
                rate_hz=self.setting.rate,
                low=c.offset - half * c.scale,
                high=c.offset + (half - 1) * c.scale,
                resolution=c.scale,
                sensor=f"{sensor} {self._options.seed:04d}",
            )
            for c, (quantity, unit, sensor) in zip(self._converters, about, strict=True)
        )

    def write_truth(self) -> None:
        """Write what is simulated to the file that was asked for, whole or not at all."""
        path: Path | None = self._options.truth
        if path is None:
            return
        truth = {
            "hidden": "+".join(self.strengths) or "none",
            "kind": generate.kind_of(self.strengths),
            "strengths": self.strengths,
            "strengths_reached": self.reached,
            "parameters": {e.name: e.parameters for e in self.bench.effects} | self.faults,
            "displacement_late_s": self.setting.lag,
            "faults": self._options.fault,
            "seed": self._options.seed,
            "releases": self._releases_seen,
        }
        described = generate.described(self.setting)
        for mine in ("hand_s", "released_at_s", "from_m", "velocity_m_s"):
            described.pop(mine)
        part = path.with_suffix(path.suffix + ".part")
        part.write_text(json.dumps(described | truth, indent=1) + "\n", encoding="utf-8")
        os.replace(part, path)


def _strength(text: str) -> tuple[str, float]:
    name, _, strength = text.partition(":")
    generate.named_strengths(name, 0.0)
    try:
        return name, float(strength)
    except ValueError:
        raise ValueError(f"a hidden effect is written NAME:STRENGTH ({name}:0.01), not {text!r}") from None


def _sort_faults(
    texts: list[str], random: np.random.Generator
) -> tuple[Lies, bool, tuple[wire.Fault, ...], dict[str, float]]:
    """Return the board's lies, whether the table is bumped, the line's faults, a smaller range."""
    lies, bumped, fixed = Lies(), False, {}
    line: list[wire.Fault] = []
    for text in texts:
        name, _, amount = text.partition(":")
        if name not in LIES:
            try:
                line.append(wire.parse_fault(text, random))
            except ValueError as error:
                raise ValueError(f"{error}, {', '.join(LIES)}") from None
        elif name == "saturation":
            fixed["range_acceleration"] = float(amount or 8.0)
        elif name == "rate-lie":
            lies.rate = lies.told_rate = 1.0 + float(amount or 0.01)
        elif name == "clock-200ppm":
            lies.rate = lies.clock = 1.0 + float(amount or 200.0) * 1e-6
        elif name == "dead-channel":
            lies.dead_channel = int(amount or 1)
        bumped |= name == "bump"
        lies.wrong_version |= name == "wrong-version"
        lies.describe |= name == "describe-lie"
        lies.counter |= name == "counter-lie"
        lies.swapped |= name == "swapped"
        lies.reversed |= name == "reversed"
    return lies, bumped, tuple(line), fixed


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
