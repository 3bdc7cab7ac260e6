"""How long a diagnosis takes, and its memory: short records, long ones, nine releases together; each in a process of its own."""

import multiprocessing
import os
import resource
import statistics
import time
from collections.abc import Callable

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from bench.regime_cases import Case, release_of
from identify.diagnosis.diagnose import diagnose
from identify.free_decay import FreeDecay
from identify.preprocessing.prepared_decay import PreparedDecay
from mocks.generate import draw

TITLE = "Waiting for a diagnosis"

SEED = 880
RUNS = 3

Releases = tuple[FreeDecay | PreparedDecay, ...]


def _one(hidden: str | None, strength: float, seed: int, **fixed: object) -> Releases:
    sample = draw(hidden, strength, seed, **fixed)
    return (FreeDecay(sample.rate, sample.displacement, sample.acceleration),)


def _nine(hidden: str | None, seed: int) -> Releases:
    case = Case(hidden, "white", "4 Hz", 9, seed)
    return tuple(release_of(case, k) for k in range(9))


LONG = {"seconds": 120.0, "mu_0": 0.003, "mu_1": 0.02}
MANY = {"seconds": 41.0, "mu_0": 0.01, "mu_1": 0.05}

CASES: tuple[tuple[str, str, Callable[[int], Releases]], ...] = (
    ("8 s, nothing missing", "2", lambda seed: _one(None, 0.0, seed)),
    ("8 s, a cubic spring", "2", lambda seed: _one("cubic_stiffness", 0.03, seed)),
    ("8 s, hysteresis", "2", lambda seed: _one("hysteresis", 0.03, seed)),
    ("8 s, two effects", "5", lambda seed: _one("freeplay+cubic_damping", 0.02, seed)),
    ("8 s, no name: a magnet", "5", lambda seed: _one("magnet", 0.01, seed)),
    ("8 s, no name: a notched spring", "5", lambda seed: _one("notched_spring", 0.03, seed)),
    ("120 s, nothing missing", "10", lambda seed: _one(None, 0.0, seed, **LONG)),
    ("120 s, a cubic spring", "10", lambda seed: _one("cubic_stiffness", 0.01, seed, **LONG)),
    ("120 s, no name: a magnet", "10", lambda seed: _one("magnet", 0.02, seed, **LONG)),
    ("160 cycles, quadratic damping", "10", lambda seed: _one("quadratic_damping", 0.01, seed, **MANY)),
    ("nine releases, nothing missing", "15", lambda seed: _nine(None, seed)),
    ("nine releases of nine strengths: no name", "15", lambda seed: _nine("cubic_stiffness", seed)),
)


def _measured(place: int, seed: int) -> tuple[float, float]:
    """Return seconds of CPU, and peak memory in MB of one case; compiled code is loaded before."""
    diagnose(_one("hysteresis", 0.03, SEED - 1))
    releases = CASES[place][2](seed)
    before = time.process_time()
    diagnose(releases)
    spent = time.process_time() - before
    return spent, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def run(quick: bool) -> str:
    """Return the section as markdown."""
    runs = 1 if quick else RUNS
    rows = []
    for place, (what, wanted, _) in enumerate(CASES):
        with multiprocessing.get_context("spawn").Pool(1, maxtasksperchild=1) as pool:
            found = [pool.apply(_measured, (place, SEED + i)) for i in range(runs)]
        seconds = [spent for spent, _ in found]
        rows.append(
            f"| {what} | {statistics.median(seconds):.1f} | {max(seconds):.1f} | {wanted} | "
            f"{max(memory for _, memory in found):.0f} |"
        )
    table = "\n".join(rows)
    return (
        "| record | CPU, s | slowest | wanted | memory, MB |\n|---|---:|---:|---:|---:|\n"
        f"{table}\n\n"
        f"Median of {runs} seed(s), two channels at 256 Hz, white noise; at most 500 MB wanted."
    )
