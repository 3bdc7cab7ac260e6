"""Recordings that others made: what the diagnosis says of each, and how far its error falls."""

import json
import os
import sys
import tempfile
from pathlib import Path

from bench.rigs import RIGS

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy loads: one thread is the fastest here

TITLE = "Recordings that others made"
DATA = Path(os.environ.get("STATION_DATA", Path(__file__).resolve().parents[1] / ".." / "shared" / "data"))
ROLL = {"columns": {"displacement": "phi"}}
SILVERBOX = {
    "columns": {"force": "V1", "displacement": "V2"},
    "units": {"force": "V", "displacement": "V"},
    "rate": 610.35,
}
RECORDINGS = (
    ("spring_disc/release_1.csv", {}, "drag"),
    ("spring_disc/release_2.csv", {}, "drag"),
    ("spring_disc/release_3_glitches.csv", {}, "drag, and a sonar that loses readings"),
    ("spring_disc/release_4_small.csv", {}, "nothing strong"),
    *((f"pohl_wheel/brake_{i:03d}mA.csv", {}, "dry friction") for i in (0, 100, 200, 400, 700)),
    ("ship_roll/model_test_21337.csv", ROLL, "hardening and nonlinear damping"),
    ("ship_roll/model_test_21338.csv", ROLL, "hardening and nonlinear damping"),
    ("silverbox/SNLS80mV.mat", SILVERBOX, "a cubic spring, no friction"),
)


def _said(name: str, options: dict, folder: Path) -> list[str]:
    from daq.importing.options import ImportOptions
    from daq.session_info import SessionInfo
    from station.exits import code_of
    from station.operations.diagnosing import diagnose_sessions
    from station.operations.session_set import open_sessions
    from station.results.sessions import import_file
    from station.settings import Settings

    file = DATA / name
    try:
        session = import_file(
            file, folder / Path(name).stem, folder, ImportOptions(**options), SessionInfo()
        ).sessions[0]
        bench = open_sessions((str(session.folder),), Settings())
        found, document = diagnose_sessions(bench)
    except Exception as error:
        if code_of(error) == 1:
            raise
        return [name, f"refused: {str(error).split(': ', 1)[-1]}", ""]
    before, after = document.error, document.error_with_named or document.error
    return [
        name,
        f"{found.verdict} {' + '.join(found.named)}".strip(),
        f"{before.motion_percent:.3g} → {after.motion_percent:.3g}",
    ]


def _hidden(folder: Path) -> str:
    from daq.importing.options import ImportOptions
    from daq.session_info import SessionInfo
    from station.operations.diagnosing import diagnose_sessions
    from station.operations.session_set import open_sessions
    from station.results.sessions import import_file
    from station.settings import Settings

    truths = json.loads((DATA / "hidden" / "truth.json").read_text())
    wrong = []
    for truth in truths:
        place = folder / truth["file"].removesuffix(".csv")
        session = import_file(
            DATA / "hidden" / truth["file"], place, folder, ImportOptions(), SessionInfo()
        ).sessions[0]
        found = diagnose_sessions(open_sessions((str(session.folder),), Settings()))[0]
        told = f"{found.verdict} {' + '.join(found.named)}".strip()
        if not _right(truth["hidden"], found.verdict, set(found.named)):
            wrong.append(f"{truth['file']} ({truth['hidden']}): {told}")
    return (
        f"Releases with a hidden effect, simulated by somebody else: {len(truths) - len(wrong)} of {len(truths)} named rightly. "
        f"Wrong: {'; '.join(wrong) or 'none'}."
    )


def _readings() -> str:
    """Return how each file is read, of those that need no options; what changes here was read otherwise before."""
    from daq.importing import ImportProblem, read_runs

    lines = ["| file | read as | rate, Hz | readings |", "|---|---|---|---|"]
    for file in sorted(
        path for path in DATA.rglob("*.*") if path.suffix not in (".md", "") and path.name != "truth.json"
    ):
        name = file.relative_to(DATA).as_posix()
        try:
            runs = read_runs(file)
        except ImportProblem as problem:
            lines.append(f"| {name} | asks: {str(problem).split(': ', 1)[-1]} | | |")
            continue
        channels = ", ".join(f"{channel.quantity} in {channel.unit}" for channel in runs[0].channels)
        lengths = ", ".join(str(run.samples.shape[1]) for run in runs)
        lines.append(f"| {name} | {channels} | {runs[0].rate:.6g} | {lengths} |")
    return "\n".join(lines)


def _right(hidden: str | None, verdict: str, named: set[str]) -> bool:
    from identify.effects.library import LIBRARY

    if not hidden or hidden in ("nothing", "none"):
        return verdict == "nothing_missing"
    wanted = set(hidden.replace(" ", "").replace(",", "+").split("+"))
    if not wanted <= {effect.name for effect in LIBRARY}:
        return verdict in ("unknown_effect", "unconfirmed")
    return named == wanted


def run(quick: bool) -> str:
    """Return the tables as markdown. Raises FileNotFoundError where the recordings are not there."""
    if not DATA.is_dir():
        raise FileNotFoundError(
            "the recordings are not here (../shared/data, or the folder named by STATION_DATA)"
        )
    lines = [
        "| recording | expected | verdict | motion error, % |",
        "|---|---|---|---|",
    ]
    print(_readings(), file=sys.stderr)
    with tempfile.TemporaryDirectory() as made:
        for name, options, expected in RECORDINGS:
            first, *said = _said(name, options, Path(made))
            row = f"| {' | '.join([first, expected, *said])} |"
            print(row, flush=True)
            if not any(name in rig.files for rig in RIGS):
                lines.append(row)
        hidden = "" if quick else "\n\n" + _hidden(Path(made))
    return (
        "\n".join(lines)
        + "\n\nMotion error: rms of the free run's residual over that of the reading."
        + hidden
    )
