"""A board that falls silent some seconds after it was started."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[2]


@contextmanager
def stalling_board(at_s: float) -> Iterator[str]:
    """Run the double with a stall of 30 s at a moment after START; give its port."""
    command = [sys.executable, "-m", "mocks", "--tcp", "0", "--fault", f"stall:30@{at_s}"]
    process = subprocess.Popen(command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    try:
        yield process.stdout.readline().removeprefix("port: ").strip()
    finally:
        process.terminate()
        process.communicate(timeout=10)
