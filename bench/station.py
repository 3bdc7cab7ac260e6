"""How long an operator waits: start of the program, identification of one session, the demo; and its memory."""

import itertools
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from daq.importing import read_file
from daq.session import Session
from mocks.forces import Effect
from mocks.testbed import Bench, Release, simulate

TITLE = "The program"

ROOT = Path(__file__).resolve().parent.parent
SAMPLE = ROOT / "tests" / "data" / "release_12.csv"


def _timed(*arguments: str, folder: Path) -> tuple[float, float]:
    """Return seconds and peak memory in MB of one run of the program in a process of its own."""
    before = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "-m", "station", *arguments],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - before
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise AssertionError(f"station {' '.join(arguments)} ended with {process.returncode}")
    return seconds, usage.ru_maxrss / 1024


def _warm(session: Path, repetitions: int) -> float:
    """Return milliseconds of both identifications on a session, compiled."""
    from identify.restoring_force.restoring_force import identify_restoring_force
    from identify.wavelet.wavelet import identify_wavelet
    from station.story.pipeline import identify
    from station.story.preparation import Options

    recording = Session.open(session).recording()
    options = Options(mass=21.36)
    result = identify(recording, options)

    def both() -> None:
        identify_wavelet(result.aligned)
        identify_restoring_force(result.aligned)

    return _median_ms(both, repetitions)


def _median_ms(act: Callable[[], object], repetitions: int) -> float:
    """Return the median of some runs in milliseconds; one before them is not counted."""
    act()
    took = []
    for _ in range(repetitions):
        before = time.perf_counter()
        act()
        took.append(time.perf_counter() - before)
    return statistics.median(took) * 1e3


def _compared(session: Path, repetitions: int) -> float:
    """Return milliseconds of the comparison of the base model with a session, the fit not counted."""
    from daq.session import Session
    from identify.comparison.compare import compare_fitted
    from identify.fitting.baseline import fit_baseline
    from identify.model.model import base_model
    from station.settings import Settings
    from station.story.preparation import prepare_session

    prepared = prepare_session(Session.open(session), Settings())
    start = fit_baseline((prepared,), base_model())
    return _median_ms(lambda: compare_fitted(start), repetitions)


def _formula(repetitions: int) -> float:
    """Return milliseconds from a formula to an effect that is compiled."""
    from identify.effects.user import parse_effect

    numbers = itertools.count(2)

    def ready() -> object:  # another formula each time: nothing is remembered
        return parse_effect(f"x = a*u/(1 + (u/b)**2)*exp(-abs(v)/c)*sgn(v) + {next(numbers)}*a*sin(u)")

    return _median_ms(ready, repetitions)


def run(quick: bool) -> str:
    """Return the section of the benchmark page."""
    repetitions = 3 if quick else 15
    rows: list[tuple[str, str, str]] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        helps = [_timed("--help", folder=folder)[0] for _ in range(repetitions)]
        _timed("import", str(SAMPLE), "--mass", "21.36", "--session", "sessions/one", folder=folder)
        session = folder / "sessions" / "one"
        colds = [_timed("identify", str(session), "--json", folder=folder) for _ in range(repetitions)]
        both = _warm(session, repetitions * 3)
        compared = _compared(session, repetitions * 3)
        formula = _formula(repetitions)
        demo, _ = _timed("demo", "--json", folder=folder)
        listed = _listed(folder)
        read = 1e3 * _shortest(lambda: Session.open(session).recording())
        table = _table_read(folder / "long.csv")
        simulated = 1e3 * _simulated()
    middle = statistics.median
    rows.append(("`station --help`", f"{middle(helps):.2f} s", "0.4 s"))
    rows.append(("`station identify SESSION`, cold", f"{middle([c[0] for c in colds]):.2f} s", "2 s"))
    rows.append(("the same, peak memory", f"{max(c[1] for c in colds):.0f} MB", "500 MB"))
    rows.append(("wavelet and restoring force, 8 s at 256 Hz, warm", f"{both:.1f} ms", "20 ms"))
    rows.append(("comparison of a fit with 8 s at 256 Hz, warm", f"{compared:.0f} ms", "100 ms"))
    rows.append(("an effect of one's own, from its formula to ready", f"{formula:.0f} ms", "300 ms"))
    rows.append(("`station demo`, without a screen", f"{demo:.1f} s", "well under 60 s"))
    rows.append(("`station list` of 10,000 sessions", f"{listed:.1f} s", "seconds"))
    rows.append(("a session of 2048 samples read", f"{read:.1f} ms", "20 ms"))
    rows.append(("a table of a million rows with decimal commas read", f"{table:.1f} s", "seconds"))
    rows.append(("8 s of the simulated testbed", f"{simulated:.1f} ms", "50 ms"))
    lines = ["| what | measured | wanted |", "|---|---:|---:|"]
    lines += [f"| {what} | {value} | {wanted} |" for what, value, wanted in rows]
    lines += ["", f"Medians of {repetitions} runs, each in its own process."]
    return "\n".join(lines)


def _shortest(work: Callable[[], object]) -> float:
    """Return the shortest of five durations, s."""
    times = []
    for _ in range(5):
        before = time.perf_counter()
        work()
        times.append(time.perf_counter() - before)
    return min(times)


def _table_read(path: Path) -> float:
    """Return the seconds that the reading of a million rows takes."""
    t = np.arange(1_000_000) / 1000.0
    rows = "".join(f"{a:.3f};{b:.6f};{c:.4f}\n" for a, b, c in zip(t, np.sin(t), np.cos(t), strict=True))
    path.write_text("Zeit [s];Weg [mm];Beschleunigung [g]\n" + rows.replace(".", ","))
    before = time.perf_counter()
    read_file(path)
    return time.perf_counter() - before


def _simulated() -> float:
    """Return the seconds that the testbed takes for one release of 8 s with Stribeck friction, compiled."""
    grid = np.arange(2048) / 256.0
    bench = Bench(effects=(Effect("stribeck_friction", {"dmu": 0.1, "vs": 0.1}),))
    return _shortest(lambda: simulate(bench, Release(0.02), grid))


def _listed(folder: Path) -> float:
    """Return the seconds that a list of 10,000 sessions takes."""
    many = folder / "many"
    info = {"name": "x", "state": "sealed", "mass_kg": 21.36, "rate_hz": 256.0}
    for number in range(10_000):
        one = many / f"release_{number:05d}"
        one.mkdir(parents=True)
        (one / "session.json").write_text(json.dumps(info))
    return _timed("list", str(many), "--json", folder=folder)[0]


if __name__ == "__main__":
    print(run("--quick" in sys.argv))
