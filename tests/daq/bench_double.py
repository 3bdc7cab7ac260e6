"""The bench's double in this process, on a pty or on TCP, with the truth about what it simulates."""

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from mocks.in_process import running

ROOT = Path(__file__).parents[2]
LINES = ("pty", "tcp")
NO_PTY = os.name == "nt"


@dataclass(frozen=True)
class Double:
    """A running double: where it listens, and what it simulates."""

    port: str
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
    with running(*where, *arguments, "--truth", str(truth)) as address:
        yield Double(address, truth)
