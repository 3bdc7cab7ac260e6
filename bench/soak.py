"""An hour's worth of captures in one process, and ten thousand sessions in one folder: what grows, and how long a check takes."""

import gc
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np

from daq.capture import CaptureSettings, capture
from daq.recording import Channel, Recording
from daq.session import Session

TITLE = "Soak"
ROOT = Path(__file__).resolve().parent.parent
SPEED = 40
WARM_UP = 10


def state() -> tuple[float, float, float]:
    """Resident memory in MB, threads, open files of this process."""
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    files = len(os.listdir("/proc/self/fd")) if Path("/proc/self/fd").exists() else 0
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6, float(threading.active_count()), float(files)


def soak(captures: int) -> np.ndarray:
    """The state after each capture, (captures, 3)."""
    states = []
    command = [sys.executable, "-m", "mocks", "--tcp", "0", "--speed", str(SPEED), "--releases", "-25"]
    with tempfile.TemporaryDirectory() as name:
        double = subprocess.Popen(command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        try:
            assert double.stdout is not None
            port = double.stdout.readline().removeprefix("port: ").strip()
            for _ in range(captures):
                session = capture(port, CaptureSettings(check_clock=False), Path(name) / "s")
                shutil.rmtree(session.folder)
                states.append(state())
        finally:
            double.terminate()
            double.communicate(timeout=10)
    return np.array(states)


def slope(values: np.ndarray) -> tuple[float, float]:
    """Growth a capture and its standard error, from blocks of ten whose means hardly know of each other."""
    size = max(len(values) // 20, 1)
    blocks = values[: len(values) // size * size].reshape(-1, size).mean(axis=1)
    at = (np.arange(len(blocks)) - (len(blocks) - 1) / 2) * size
    found = float(at @ blocks / (at @ at))
    left = blocks - blocks.mean() - found * at
    return found, float(np.sqrt(left @ left / max(len(blocks) - 2, 1) / (at @ at)))


def verified_in(count: int) -> float:
    """Seconds that the command `station verify` takes for so many sessions."""
    t = np.arange(2304) / 256.0
    samples = np.vstack([0.02 * np.cos(25 * t), -12.5 * np.cos(25 * t)])
    channels = (Channel("u", "displacement", "m"), Channel("a", "acceleration", "m/s^2"))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "sessions"
        first = Session.create_imported(
            folder / "s00000", Recording(256.0, channels, samples, np.ones(2304, dtype=bool)), None
        )
        for i in range(1, count):
            shutil.copytree(first.folder, folder / f"s{i:05d}")
        names = [str(path) for path in sorted(folder.iterdir())]
        began = time.perf_counter()
        done = subprocess.run(
            [sys.executable, "-m", "station", "verify", "--json", *names], cwd=ROOT, stdout=subprocess.DEVNULL
        )
        end = time.perf_counter()
        if done.returncode:
            raise RuntimeError(f"verify ended with {done.returncode}")
    return end - began


def run(quick: bool) -> str:
    captures, sessions = (30, 500) if quick else (400, 10_000)
    states = soak(captures)
    warm = states[min(WARM_UP, len(states) // 3) :]
    (grown, std), first, last = slope(warm[:, 0]), warm[0], warm[-1]
    return (
        f"{captures} captures in one process, without the first {len(states) - len(warm)}: resident memory {first[0]:.1f} to {last[0]:.1f} "
        f"MB, {grown:+.4f} ± {std:.4f} MB a capture; threads {first[1]:.0f} to {last[1]:.0f}, open files {first[2]:.0f} to {last[2]:.0f}."
        f"\n\n`station verify` of {sessions} sessions of 9 s: {verified_in(sessions):.2f} s."
    )
