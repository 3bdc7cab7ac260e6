"""Results of one session written by two processes, and by one that is killed: what is lost, and what is left half done."""

import json
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

from daq.session import Session, recover, unsealed_sessions, verify

ROOT = Path(__file__).resolve().parent.parent
DATA = ROOT / "tests" / "data" / "release_24.csv"

WRITES = """
import sys
from daq.session import Session
for number in range(int(sys.argv[3])):
    Session.open(sys.argv[1]).write_result(f"{sys.argv[2]}{number}.json", "{}")
"""
PAIRS = """
import sys
from daq.session import Session
session = Session.open(sys.argv[1])
print("begun", flush=True)
for number in range(10**9):
    text = str(number) * 10_000
    session.write_results({"ladder.json": text, "model.json": text})
"""


def made(folder: Path) -> Path:
    """Import a release into a new session."""
    subprocess.run(
        [sys.executable, "-m", "station", "import", str(DATA), "--session", str(folder)],
        cwd=ROOT, capture_output=True, check=True,
    )  # fmt: skip
    return folder


def two_writers(session: Path, each: int) -> tuple[int, int]:
    """Let two processes write results into a session at once; return (writes that failed, results that are missing)."""
    writers = [
        subprocess.Popen([sys.executable, "-c", WRITES, str(session), name, str(each)], cwd=ROOT)
        for name in "ab"
    ]
    failed = sum(writer.wait() != 0 for writer in writers)
    known = Session.open(session).manifest().files
    missing = sum(f"results/{name}{number}.json" not in known for name in "ab" for number in range(each))
    return failed, missing + len(verify(session).problems)


def killed_writer(folder: Path, seed: int) -> tuple[bool, str]:
    """Kill a process that writes pairs of results; return whether a change was cut off, and what is wrong after `recover`."""
    process = subprocess.Popen(
        [sys.executable, "-c", PAIRS, str(folder)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    assert process.stdout is not None
    process.stdout.readline()
    time.sleep(random.Random(seed).uniform(0.0, 0.1))
    process.send_signal(signal.SIGKILL)
    process.communicate()
    cut_off = not verify(folder).ok
    if cut_off and folder not in unsealed_sessions(folder.parent):
        return cut_off, "cut off, and `recover` does not see it"
    recover(folder)
    if not verify(folder).ok:
        return cut_off, "; ".join(verify(folder).problems)
    results = [folder / "results" / name for name in ("ladder.json", "model.json")]
    kept = {file.read_bytes() if file.exists() else b"" for file in results}
    return cut_off, "" if len(kept) == 1 else "a pair of which one is old and one new"


def two_refinements(folder: Path) -> str:
    """Add two effects to one ladder at once by two commands; return what is wrong, and "" where nothing is."""
    commands = [
        subprocess.Popen(
            [sys.executable, "-m", "station", "refine", str(folder), "--add", effect, "--no-viewer", "--json"],
            cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        )
        for effect in ("cubic_stiffness", "quadratic_damping")
    ]  # fmt: skip
    said = [command.communicate()[1] for command in commands]
    codes = sorted(command.returncode for command in commands)
    steps = len(json.loads((folder / "results" / "ladder.json").read_text())["steps"])
    if steps - 1 != codes.count(0) or any(code not in (0, 9) for code in codes):
        return f"exit codes {codes}, {steps} steps: {' '.join(said)[-200:]}"
    return "" if verify(folder).ok else "; ".join(verify(folder).problems)


def rows(folder: Path, quick: bool) -> tuple[list[str], list[str]]:
    """Return the rows of the table (what, tried, nothing lost) and what went wrong."""
    each, kills, pairs = (20, 10, 1) if quick else (150, 200, 10)
    sound = made(folder / "sound")
    session = Path(shutil.copytree(sound, folder / "writers"))
    bad = []
    failed, missing = two_writers(session, each)
    if failed or missing:
        bad.append(f"two writers: {failed} ended, {missing} results missing")
    killed = [killed_writer(session, seed) for seed in range(kills)]
    refined = []
    for number in range(pairs):
        refined.append(two_refinements(Path(shutil.copytree(sound, folder / f"ladder{number}"))))
    bad += [f"killed writer {i}: {what}" for i, (_, what) in enumerate(killed) if what]
    bad += [f"two refinements {i}: {what}" for i, what in enumerate(refined) if what]
    return [
        f"| two processes write results into one session at once | {2 * each} | {2 * each - missing} |",
        f"| `kill -9` while results are written, then `station recover` | {kills} | "
        f"{sum(not what for _, what in killed)} |",
        f"| two `station refine --add` at once | {pairs} | {sum(not what for what in refined)} |",
    ], bad
