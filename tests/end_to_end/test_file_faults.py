"""Every fault of files, writers and users in docs/faults.md, injected as it is, ends as the page promises."""

import errno
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from fault_bench import PAGE, board, station_capture

from daq import raw_log, session_folder, storage
from daq.recording import Channel, Recording
from daq.session import Session, verify
from daq.storage import Lock
from station import cli
from station.operations import refining

ROOT = Path(__file__).parents[2]
COLUMNS = ["fault", "injected", "command", "exit", "words"]
HELD: list[Lock] = []
DATA = ROOT / "tests" / "data" / "release_24.csv"

pytestmark = [
    pytest.mark.usefixtures("unrendered"),
    pytest.mark.skipif(os.name == "nt", reason="pipes, links and signals of POSIX"),
]


class Promise(NamedTuple):
    """A row of the table."""

    fault: str
    injected: str
    command: str
    code: int
    words: str


def promises() -> list[Promise]:
    rows = [
        [cell.strip() for cell in line.strip().strip("|").split("|")]
        for line in PAGE.read_text(encoding="utf-8").splitlines()
        if line.startswith("|") and line.count("|") == len(COLUMNS) + 1
    ]
    assert rows[0] == COLUMNS
    return [Promise(f, i, command, int(code), words) for f, i, command, code, words in rows[2:]]


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder to work in, with one session in ./sessions and a file beside it that nobody may touch."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "precious").write_text("mine")
    samples = np.sin(np.arange(64) / 5.0)[np.newaxis]
    recording = Recording(64.0, (Channel("u", "displacement", "m"),), samples, np.ones(64, dtype=bool))
    Session.create_imported(tmp_path / "sessions" / "s", recording, None).write_result("a.json", "old")
    yield tmp_path
    while HELD:
        HELD.pop().release()


def _fill_the_disk(place: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Refuse every write below ./sessions once 20 kB of samples are there, as a full disk does."""
    (place / "tmp").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(place / "tmp"))
    log = place / "sessions" / "new" / "raw.log"
    real_open, real_write = storage.open_regular, os.write

    def write(fd: int, data: bytes) -> int:
        status = os.fstat(fd)
        if log.exists() and os.path.samestat(status, log.stat()) and status.st_size > 20_000:
            raise OSError(errno.ENOSPC, "No space left on device")
        return real_write(fd, data)

    def opened(path: Path, flags: int) -> int:
        if flags & os.O_CREAT and path.parent == log.parent and log.exists():
            raise OSError(errno.ENOSPC, "No space left on device")
        return real_open(path, flags)

    monkeypatch.setattr(raw_log.os, "write", write)
    monkeypatch.setattr(storage, "open_regular", opened)
    return []


def _change_the_ladder(place: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Let another one write the ladder while this one fits: two terminals with `refine --add` (`bench.writers` has two)."""
    assert cli.run(["import", str(DATA), "--session", "sessions/r"]) == 0
    fit = refining.add_effect

    def meanwhile(*given: object, **named: object) -> object:
        Session.open(place / "sessions" / "r").write_result("ladder.json", "{}")
        return fit(*given, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(refining, "add_effect", meanwhile)
    return ["r", "--add", "cubic_stiffness", "--no-viewer"]


def _hold_the_lock(place: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    assert cli.run(["import", str(DATA), "--session", "sessions/r"]) == 0
    monkeypatch.setattr(session_folder, "WAIT_S", 0.05)
    HELD.append(Lock(place / "sessions" / "r"))
    HELD[-1].acquire()
    return ["r", "--reset", "--no-viewer"]


KILLED = """
import os, signal
from daq.session import Session
real = os.replace
def replace(source, to):
    real(source, to)
    os.kill(os.getpid(), signal.SIGKILL)
os.replace = replace
Session.open("sessions/s").write_results({"a.json": "new", "b.json": "new"})
"""


def _kill(place: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", KILLED], cwd=place, env=environment, check=False)
    assert done.returncode == -signal.SIGKILL
    return []


def _settings(place: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    (place / "station.toml").write_text('[capture]\nport = "spy:///dev/null?file=precious"\n')
    return []


def _without_manifest(place: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    (place / "sessions" / "s" / "manifest.json").unlink()
    return []


def _pipe(place: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """One session with a pipe; another one that is to be recovered all the same."""
    other = Path(shutil.copytree(place / "sessions" / "s", place / "sessions" / "t"))
    (other / "manifest.json").unlink()
    os.mkfifo(place / "sessions" / "s" / ".lock")
    return _without_manifest(place, monkeypatch)


def _link(place: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    (place / "sessions" / "s" / ".lock").symlink_to(place / "made")
    return _without_manifest(place, monkeypatch)


def _linked_folder(place: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    (place / "sessions" / "s" / "more").symlink_to(place)
    return []


INJECTED: dict[str, Callable[[Path, pytest.MonkeyPatch], list[str]]] = {
    "writes refused": _fill_the_disk,
    "`spy://`": lambda *_: ["--port", "SPY:///dev/null?file=precious"],
    "file named": lambda *_: ["--port", "precious"],
    "`spy://` in station.toml": _settings,
    "ladder changed": _change_the_ladder,
    "lock held": _hold_the_lock,
    "SIGKILL": _kill,
    "manifest removed": _without_manifest,
    "pipe": _pipe,
    "link": _link,
    "linked folder": _linked_folder,
}


@pytest.mark.parametrize("promise", promises(), ids=lambda promise: promise.fault)
def test_a_fault_of_files_ends_as_the_page_promises(
    promise: Promise, place: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    arguments = INJECTED[promise.injected](place, monkeypatch)
    capfd.readouterr()
    if promise.injected == "writes refused":
        with board("tcp", "--seed", "5", "--speed", "16") as port:
            outcome = station_capture(port, place / "sessions" / "new", "--duration", "3")
        code, said = outcome.code, outcome.said
        (moved,) = (place / "tmp").iterdir()
        assert str(moved) in said
        assert verify(moved).ok
        assert Session.open(moved).recording().valid.all()
    else:
        names = ["s"] if promise.command == "verify" else []
        code = cli.run([promise.command, *names, *arguments])
        said = "".join(capfd.readouterr())
    assert code == promise.code, said
    assert promise.words in " ".join(said.split())
    assert "fault of this program" not in said
    assert (place / "precious").read_text() == "mine"
    assert not (place / "made").exists()
    if promise.command == "recover":
        assert verify(place / "sessions" / "s").ok == (code == 0)
    assert not (place / "sessions" / "t").exists() or verify(place / "sessions" / "t").ok
