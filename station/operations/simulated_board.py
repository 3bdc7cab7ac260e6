"""The simulated board, started as a program of its own, and one release of it."""

import contextlib
import json
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from daq.capture import CaptureSettings
from daq.session import Session
from station.exits import Problem
from station.operations.capturing import record
from station.operations.new_session import capture_settings
from station.output import progress
from station.settings import Settings

MASS_KG = 21.36
"""Of the bench that it simulates."""


@contextlib.contextmanager
def simulated_board(seed: int, speed: float, *more: str, module: str = "mocks") -> Iterator[str]:
    """Start the simulated board, give the name of its port, and end it afterwards."""
    arguments = ["--tcp", "0", "--seed", str(seed), "--speed", f"{speed:g}", *more]
    with subprocess.Popen(
        [sys.executable, "-m", module, *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            assert process.stdout is not None
            first = process.stdout.readline().strip()
            if not first.startswith("port: "):
                process.kill()
                complaint = process.communicate()[1].strip().splitlines()
                raise Problem(
                    f"the simulated board did not start: {complaint[-1] if complaint else 'it gave no reason'}"
                )
            yield first.removeprefix("port: ")
        finally:
            process.terminate()


@contextlib.contextmanager
def told_board(
    seed: int, speed: float, *more: str, module: str = "mocks"
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Start the simulated board; give its port, and what is empty until the board has ended: how it was made."""
    truth: dict[str, Any] = {}
    with TemporaryDirectory() as temporary:
        envelope = Path(temporary) / "truth.json"
        with simulated_board(seed, speed, *more, "--truth", str(envelope), module=module) as port:
            yield port, truth
        truth |= json.loads(envelope.read_bytes())


def simulated_capture(settings: Settings, specimen: str, speed: float) -> CaptureSettings:
    """Say how the simulated bench is captured; at another speed than its own no clock can be checked."""
    wanted = capture_settings(settings, specimen=specimen, mass=MASS_KG, operator="demo")
    return replace(wanted, check_clock=speed == 1.0)


def record_simulated(
    settings: Settings, specimen: str, seed: int, speed: float, folder: Path, with_viewer: bool, module: str
) -> tuple[Session, int | None, dict[str, Any]]:
    """Record one release; return the session, the live viewer's port, and how the board was made.

    The samples are a function of the seed: at any `speed`, on any line, the same are recorded.
    """
    with told_board(seed, speed, module=module) as (port, truth):
        progress(f"a simulated board answers at {port}")
        wanted = simulated_capture(settings, specimen, speed)
        session, shown_at = record(port, wanted, folder, with_viewer)
    return session, shown_at, truth
