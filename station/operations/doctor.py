"""What `station doctor` looks at, one function a subject; each yields findings: PASS, WARN or FAIL, and the remedy."""

import platform
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryFile
from typing import Literal

import numpy as np

from daq.clock_check import CLOCK_LIMIT, SIGMAS
from daq.errors import StationError
from daq.ports import BoardSample, holders, latency_ms, list_ports, sample_board
from daq.recording import Recording

PACKAGES = ("numpy", "scipy", "numba", "pyserial", "rerun-sdk", "pydantic", "rich")
SPACE_MB = (50, 1000)
LATENCY_MS = 16


Grade = Literal["PASS", "WARN", "FAIL"]
"""How a check ended."""


@dataclass(frozen=True)
class Finding:
    """One check: what was looked at, what was found (with units), and the remedy unless it passed."""

    grade: Grade
    check: str
    found: str
    remedy: str = ""


def examine(port: str | None, sessions: Path, rate: float, seconds: float) -> Iterator[Finding]:
    """Check the computer, and a port with its board: the one that is named, or each on which a board answers."""
    yield Finding("PASS", "Python", f"{platform.python_version()} on {platform.system()}")
    yield Finding("PASS", "packages", ", ".join(f"{name} {version(name)}" for name in PACKAGES))
    yield from _disk(sessions)
    if port:
        yield from _board(port, rate, seconds)
        return
    candidates = list_ports()
    if not candidates:
        remedy = "plug the board in, or name --port"
        yield Finding("WARN", "ports", "this computer has no serial port", remedy)
    for candidate in candidates:
        if candidate.answers:
            yield from _board(candidate.port.name, rate, seconds)
        else:
            remedy = "ignore this if no board is meant to be on that port"
            yield Finding("WARN", "port", candidate.problem, remedy)


def _disk(sessions: Path) -> Iterator[Finding]:
    """Check that there is space where sessions will be written, and that one can write there."""
    folder = next(p for p in (sessions, *sessions.absolute().parents) if p.is_dir())
    free = shutil.disk_usage(folder).free / 1e6
    grade: Grade = "FAIL" if free < SPACE_MB[0] else "WARN" if free < SPACE_MB[1] else "PASS"
    yield Finding(grade, "disk space", f"{free:,.0f} MB free in {folder}", "make room, or use another disk")
    try:
        TemporaryFile(dir=folder).close()
    except OSError as error:
        remedy = "choose another folder for the sessions, or mend its permissions"
        yield Finding("FAIL", "disk", f"{folder} cannot be written: {error.strerror}", remedy)


def _board(name: str, rate: float, seconds: float) -> Iterator[Finding]:
    """Check a port from outside (free, quick), then what its board sends."""
    if found := holders(name):
        who = ", ".join(f"{program} (process {pid})" for program, pid in found)
        yield Finding("WARN", "held by", who, "close that program")
    if (latency := latency_ms(name)) is not None:
        grade: Grade = "WARN" if latency >= LATENCY_MS else "PASS"
        remedy = "lower it: echo 1 | sudo tee /sys/class/tty/NAME/device/latency_timer"
        yield Finding(grade, "latency", f"{latency} ms in the adapter", remedy)
    try:
        sample = sample_board(name, seconds, rate)
    except StationError as error:
        what, _, remedy = str(error).rpartition("; ")
        yield Finding("FAIL", "board", what or remedy, remedy if what else "")
        return
    hello, recording = sample.hello, sample.recording
    taken_s = len(recording.valid) / recording.rate
    lost = int((~recording.valid).sum())
    yield Finding("PASS", "handshake", f"{hello.board}, firmware {hello.firmware}")
    yield Finding(
        "WARN" if lost or sample.damaged else "PASS",
        "line",
        f"{lost} of {len(recording.valid)} samples lost, {sample.damaged} frames damaged in {taken_s:.1f} s",
        "a shorter cable, another hub, or a slower rate",
    )
    yield from _levels(recording)
    yield _rate(sample)


def _noise(samples: np.ndarray) -> float:
    """Standard deviation by third differences: a slow motion under the noise does not count."""
    if len(samples) < 8:
        return float("nan")
    return float(np.median(np.abs(np.diff(samples, 3))) / 0.6745 / np.sqrt(20))


def _levels(recording: Recording) -> Iterator[Finding]:
    for channel, all_samples in zip(recording.channels, recording.samples, strict=True):
        samples = all_samples[recording.valid]
        level, noise, span = float(samples.mean()), _noise(samples), float(np.ptp(samples))
        text = f"level {level:.4g}, noise {noise:.2g}, span {span:.2g} {channel.unit}"
        ends = ((channel.low, samples.min()), (channel.high, samples.max()))
        near = 1.01 * (channel.resolution or 0.0)
        grade: Grade = "PASS"
        remedy = ""
        if span == 0.0:
            grade, remedy = "FAIL", "the reading never changes: check the sensor, its supply and its wire"
        elif any(end is not None and abs(value - end) <= near for end, value in ends):
            grade, remedy = "FAIL", "at the end of its range: centre the sensor, or take a wider range"
        yield Finding(grade, channel.name, text, remedy)


def _rate(sample: BoardSample) -> Finding:
    stated, clock = sample.recording.rate, sample.clock
    if clock is None or not np.isfinite(clock.std):
        return Finding("WARN", "rate", f"{stated:g} Hz by the board, too few frames to check it")
    text = f"{stated:g} Hz by the board, {clock.rate:.2f} ± {clock.std:.2f} Hz by this computer"
    off = abs(clock.rate / stated - 1) > max(CLOCK_LIMIT, SIGMAS * clock.std / stated)
    return Finding("FAIL" if off else "PASS", "rate", text, "correct the rate in the firmware")
