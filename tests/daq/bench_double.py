"""The bench's double as a process of its own, on a pty or on TCP."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
LINES = ("pty", "tcp")
NO_PTY = os.name == "nt"


@dataclass(frozen=True)
class Double:
    """A running double: where it listens, and what it simulates."""

    port: str
    process: "subprocess.Popen[str]"
    truth_file: Path

    def truth(self) -> dict[str, Any]:
        """The truth as it is written when a release has been drawn."""
        return json.loads(self.truth_file.read_text())


@contextmanager
def double(folder: Path, line: str, *arguments: str) -> Iterator[Double]:
    """Run the double until the block ends; skipped where there is no pty."""
    if line == "pty" and NO_PTY:
        pytest.skip("this system has no pty")
    truth = folder / "truth.json"
    where = ["--pty"] if line == "pty" else ["--tcp", "0"]
    command = [sys.executable, "-m", "mocks", *where, *arguments, "--truth", str(truth)]
    process = subprocess.Popen(
        command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    try:
        said = process.stdout.readline()
        if not said.startswith("port: "):
            process.kill()
            raise AssertionError(f"the double said {said!r} {process.communicate()[1]!r}")
        yield Double(said.removeprefix("port: ").strip(), process, truth)
    finally:
        process.terminate()
        process.communicate(timeout=10)
