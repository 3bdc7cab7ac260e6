"""How long an operator waits: start of the program, identification of one session, the demo; and its memory."""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

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


def _warm(session: Path, repetitions: int) -> tuple[float, float]:
    """Return milliseconds of the wavelet and the restoring force together, and of the whole pipeline."""
    from daq.session import Session
    from identify.restoring_force.restoring_force import identify_restoring_force
    from identify.wavelet.wavelet import identify_wavelet
    from station.story.pipeline import identify
    from station.story.preparation import Options

    recording = Session.open(session).recording()
    options = Options(mass=21.36)
    result = identify(recording, options)
    both, whole = [], []
    for _ in range(repetitions):
        before = time.perf_counter()
        identify_wavelet(result.aligned)
        identify_restoring_force(result.aligned)
        both.append(time.perf_counter() - before)
        before = time.perf_counter()
        identify(recording, options)
        whole.append(time.perf_counter() - before)
    return statistics.median(both) * 1e3, statistics.median(whole) * 1e3


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
        both, whole = _warm(session, repetitions * 3)
        demo, _ = _timed("demo", "--json", folder=folder)
        views = [
            _timed("view", str(session), "--no-viewer", folder=folder)
            for _ in range(max(1, repetitions // 3))
        ]
        listed = _listed(folder)
    middle = statistics.median
    rows.append(("`station --help`", f"{middle(helps):.2f} s", "0.4 s"))
    rows.append(("`station identify SESSION`, cold", f"{middle([c[0] for c in colds]):.2f} s", "2 s"))
    rows.append(("the same, slowest", f"{max(c[0] for c in colds):.2f} s", "2 s"))
    rows.append(("the same, peak memory", f"{max(c[1] for c in colds):.0f} MB", "500 MB"))
    rows.append(("wavelet and restoring force, 8 s at 256 Hz, warm", f"{both:.1f} ms", "20 ms"))
    rows.append(("recording to both results, warm", f"{whole:.0f} ms", ""))
    rows.append(
        ("`station view SESSION --no-viewer` (all tabs), cold", f"{middle([v[0] for v in views]):.2f} s", "")
    )
    rows.append(("the same, peak memory", f"{max(v[1] for v in views):.0f} MB", ""))
    rows.append(("`station demo`, without a screen", f"{demo:.1f} s", "well under 60 s"))
    rows.append(("`station list` of 10,000 sessions", f"{listed:.1f} s", "seconds"))
    lines = ["| what | measured | wanted |", "|---|---:|---:|"]
    lines += [f"| {what} | {value} | {wanted} |" for what, value, wanted in rows]
    lines += ["", f"Medians of {repetitions} runs in processes of their own, the bytecode compiled before."]
    return "\n".join(lines)


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
