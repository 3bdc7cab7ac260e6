"""Everything that a command line asks for, drawn from its seed and built: bench, sensors, board, line."""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from firmware_protocol import ChannelDescription
from mocks import faults as wire, generate
from mocks.acquisition import Acquisition, Converter
from mocks.bench_parameters import draw_parameters, draw_release_time
from mocks.board import Board
from mocks.broken_sensors import BROKEN_SENSORS, parse_broken
from mocks.effect_scaling import add_effects
from mocks.forces import PARAMETERS
from mocks.holder import MAGNET_S, Chunk, Holder
from mocks.misconfigurations import MISCONFIGURATIONS, Misconfiguration
from mocks.operator_sequence import Episode, OperatorSequence, parse_releases
from mocks.sensor_faults import SENSOR_FAULTS
from mocks.testbed import Release, simulate

#: Offsets that calibration has found and DESCRIBE states, m and m/s^2.
CALIBRATION = (4e-4, -0.25)


class SimulatedBoard:
    """What `options` ask for (see `cli`): `board`, `line` and the truth about them.

    ValueError in words for what cannot be had.
    """

    def __init__(self, options: argparse.Namespace) -> None:
        self._options = options
        self._random = np.random.default_rng([options.seed, 7])
        self._releases: list[dict[str, Any]] = []
        self._captures = 0
        fixed: dict[str, float] = {}
        if options.lag_ms is not None:
            fixed["lag"] = options.lag_ms * 1e-3
        if options.release_ms is not None:
            fixed["release_time"] = options.release_ms * 1e-3
        broken = [text for text in options.fault if text.partition(":")[0] in BROKEN_SENSORS]
        others = [text for text in options.fault if text not in broken]
        self.misconfiguration, bumped, line_faults, fixed_range = _sort_faults(others, self._random)
        self.drawn = draw_parameters(options.seed, fixed | fixed_range)
        releases = parse_releases(
            options.releases or f"{self.drawn.amplitude * 1e3:.6f}", self._release_times(options)
        )
        strengths = dict(_strength(text) for text in options.hide)
        self._add_hidden(strengths, releases)
        self.sequence = OperatorSequence(self.bench, releases, bumped)
        self.holder = self._built_holder(options)
        simulate(self.bench, releases[0], np.arange(0.0, 0.1, 0.01))  # Compiles before a host waits.
        self.line = wire.Line(line_faults, np.random.default_rng([options.seed, 8]))
        self._sensors = self.drawn.sensors
        self._converters = tuple(
            Converter(2.0 * limit / 2.0**self.drawn.bits, offset, self.drawn.bits)
            for limit, offset in zip(
                (self.drawn.range_displacement, self.drawn.range_acceleration), CALIBRATION, strict=True
            )
        )
        amplitude = abs(releases[0].displacement) or abs(releases[0].velocity) / self.bench.angular_frequency
        peaks = (amplitude, amplitude * self.bench.stiffness)
        largest = tuple(
            peak / converter.scale for peak, converter in zip(peaks, self._converters, strict=True)
        )
        self.misconfiguration.broken = tuple(parse_broken(text, largest, options.seed) for text in broken)
        memory = options.memory_s or (12.0 * max(1.0, options.speed) if options.speed else 600.0)
        self.board = Board(
            self._channels(),
            self._source,
            self._random,
            time.monotonic(),
            options.speed,
            self.misconfiguration,
            memory,
            self.holder,
        )

    def _built_holder(self, options: argparse.Namespace) -> Holder | None:
        if options.holder is None:
            return None
        try:
            low, high = (float(word) * 1e-3 for word in options.holder.split(","))
        except ValueError:
            raise ValueError(f"--holder is written LOW,HIGH in mm (-25,25), not {options.holder!r}") from None
        if not low <= 0.0 <= high or low == high:
            raise ValueError(
                f"--holder {options.holder}: the limits must lie on both sides of 0, or one be 0"
            )
        return Holder(
            self.bench, low, high, MAGNET_S if options.release_ms is None else self.drawn.release_time
        )

    def _release_times(self, options: argparse.Namespace) -> Iterator[float]:
        random = np.random.default_rng([options.seed, 9])
        while True:
            drawn = draw_release_time(random)
            yield self.drawn.release_time if options.release_ms is not None else drawn

    def _add_hidden(self, strengths: dict[str, float], releases: tuple[Release, ...]) -> None:
        """Fix the size of everything hidden on the largest release of the sequence."""
        plain = self.drawn.bench
        largest = max(
            releases, key=lambda r: max(abs(r.displacement), abs(r.velocity) / plain.angular_frequency)
        )
        physics = {n: s for n, s in strengths.items() if n in PARAMETERS}
        self.bench, reached = add_effects(plain, largest, physics, self._options.seed)
        sensor = {n: s for n, s in strengths.items() if n in SENSOR_FAULTS}
        reference = dataclasses.replace(
            self.drawn,
            amplitude=largest.displacement,
            velocity=largest.velocity,
            release_time=largest.release_time,
        )
        found = generate.find_faults(self.bench, reference, sensor, self._options.seed, {})[1]
        if "dropouts" in sensor:
            found["dropouts"] = generate.find_dropouts(
                self.bench, reference, sensor["dropouts"], self._options.seed
            )
        self.faults = {name: parameters for name, (parameters, _) in found.items()}
        if "channel_lag" in self.faults:
            late = self.drawn.lag + self.faults["channel_lag"]["lag"]
            self.drawn = dataclasses.replace(self.drawn, lag=late)
        self.reached = reached | {name: strength for name, (_, strength) in found.items()}
        self.strengths = strengths

    def _source(self, rate: float) -> Acquisition:
        self._captures += 1
        capture = self._captures

        def released(episode: Episode | Chunk, sample: float) -> None:
            assert episode.release is not None
            if isinstance(episode, Episode) and all(entry["capture"] != capture for entry in self._releases):
                self.sequence.use_up(episode)
            self._releases.append(
                {
                    "capture": capture,
                    "sample": sample,
                    "from_m": episode.release.displacement,
                    "velocity_m_s": episode.release.velocity,
                    "hand_s": episode.release.release_time,
                }
            )
            self.write_truth()

        return Acquisition(
            self.bench,
            self.sequence.capture(self._random) if self.holder is None else self.holder.capture(),
            rate,
            (self._sensors["displacement"], self._sensors["acceleration"]),
            (self._converters[0], self._converters[1]),
            self.faults,
            self._random,
            released,
            self.misconfiguration.late_s,
        )

    def _channels(self) -> tuple[ChannelDescription, ...]:
        about = (
            ("displacement", "m", "Simulated LVDT"),
            ("acceleration", "m/s^2", "Simulated accelerometer"),
        )
        half = 2 ** (self.drawn.bits - 1)
        return tuple(
            ChannelDescription(
                name=quantity,
                quantity=quantity,
                unit=unit,
                scale=c.scale,
                offset=c.offset,
                rate_hz=self.drawn.rate,
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
            "displacement_late_s": self.drawn.lag,
            "faults": self._options.fault,
            "seed": self._options.seed,
            "releases": self._releases,
        }
        described = generate.described(self.drawn)
        for mine in ("hand_s", "released_at_s", "from_m", "velocity_m_s"):
            described.pop(mine)
        part = path.with_suffix(path.suffix + ".part")
        part.write_text(json.dumps(described | truth, indent=1) + "\n", encoding="utf-8")
        os.replace(part, path)


def _strength(text: str) -> tuple[str, float]:
    name, _, strength = text.partition(":")
    generate.named_strengths(name, 0.0)
    try:
        share = float(strength)
    except ValueError:
        raise ValueError(f"a hidden effect is written NAME:STRENGTH ({name}:0.01), not {text!r}") from None
    if not 0.0 <= share < 1.0:
        raise ValueError(
            f"--hide {text}: the strength is the effect's share of the total, from 0 to below 1 ({name}:0.01 is one percent)"
        )
    return name, share


def _sort_faults(
    texts: list[str], random: np.random.Generator
) -> tuple[Misconfiguration, bool, tuple[wire.Fault, ...], dict[str, float]]:
    """Sort the faults: what is wrong with the board, whether the table is bumped, the line's faults, a smaller range."""
    misconfiguration, bumped, fixed = Misconfiguration(), False, {}
    line: list[wire.Fault] = []
    for text in texts:
        name, _, amount = text.partition(":")
        if name not in MISCONFIGURATIONS:
            line.append(wire.parse_fault(text, random, (*MISCONFIGURATIONS, *BROKEN_SENSORS)))
        elif name == "saturation":
            fixed["range_acceleration"] = float(amount or 8.0)
        elif name == "wrong-rate":
            misconfiguration.rate = misconfiguration.time_stamp_rate = 1.0 + float(amount or 0.01)
        elif name == "clock-200ppm":
            misconfiguration.rate = misconfiguration.clock = 1.0 + float(amount or 200.0) * 1e-6
        elif name == "dead-channel":
            misconfiguration.dead_channel = int(amount or 1)
        elif name == "pause":
            misconfiguration.pause_s = float(amount or 0.03)
        elif name == "clock-jump":
            misconfiguration.jump_s = float(amount or 3.0)
        elif name == "wander":
            misconfiguration.wander = float(amount or 0.5)
        elif name == "jitter":
            misconfiguration.jitter = float(amount or 0.45)
        elif name == "long-frames":
            misconfiguration.frame_s = float(amount or 0.5)
        elif name == "false-drop":
            misconfiguration.false_drop = int(amount or 1000)
        elif name == "clock-says":
            misconfiguration.clock_says = float(amount or 1e-300)
        bumped |= name == "bump"
        misconfiguration.wrong_version |= name == "wrong-version"
        misconfiguration.describe |= name == "wrong-description"
        misconfiguration.counter |= name == "wrong-counter"
        misconfiguration.swapped |= name == "swapped"
        misconfiguration.reversed |= name == "reversed"
        misconfiguration.resend |= name == "wrong-resend"
        misconfiguration.endless |= name == "endless-resend"
        misconfiguration.wrong_end |= name == "wrong-end"
        misconfiguration.second_stream |= name == "second-stream"
        misconfiguration.same_names |= name == "same-names"
        misconfiguration.forged |= name == "forged-text"
        misconfiguration.silent |= name == "no-description"
        misconfiguration.index_stamps |= name == "index-stamps"
        misconfiguration.no_range |= name == "no-range"
    return misconfiguration, bumped, tuple(line), fixed
