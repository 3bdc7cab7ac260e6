"""The simulated board, started as a program of its own."""

import contextlib
import subprocess
import sys
from collections.abc import Iterator

from station.exits import Problem


@contextlib.contextmanager
def simulated_board(seed: int, speed: float, pty: bool, *more: str, module: str = "mocks") -> Iterator[str]:
    """Start the simulated board, give the name of its port, and end it afterwards."""
    line = ["--pty"] if pty else ["--tcp", "0"]
    arguments = [*line, "--seed", str(seed), "--speed", f"{speed:g}", *more]
    process = subprocess.Popen(
        [sys.executable, "-m", module, *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    try:
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
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(timeout=5)
        if process.poll() is None:
            process.kill()
            process.wait()
        for stream in (process.stdin, process.stdout, process.stderr):
            if stream is not None:
                stream.close()
