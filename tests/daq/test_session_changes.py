"""Results and manifest are one change: with another writer at the same time, and killed at any moment."""

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from threading import Barrier, Thread

import numpy as np
import pytest

from daq import manifest
from daq.errors import OperatorError, SessionChanged, SessionLocked, StorageError
from daq.manifest import Verification
from daq.recording import Channel, Recording
from daq.session import Session, State, recover, unsealed_sessions, verify
from daq.storage import Lock, digest, write_whole

ROOT = Path(__file__).parents[2]
OLD = {"ladder.json": b"old ladder", "model.json": b"old model"}
NEW = {"ladder.json": b"new ladder", "model.json": b"new model", "report.html": b"new report"}

posix_only = pytest.mark.skipif(os.name == "nt", reason="forks, pipes and links of POSIX")


@pytest.fixture
def session(tmp_path: Path) -> Session:
    samples = np.sin(np.arange(64) / 5.0)[np.newaxis]
    recording = Recording(64.0, (Channel("u", "displacement", "m"),), samples, np.ones(64, dtype=bool))
    made = Session.create_imported(tmp_path / "sessions" / "s", recording, None)
    made.write_results(OLD)
    return made


def change_cut_off(session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    """Begin to write the new results, and stop before the first of them is in its place."""
    with monkeypatch.context() as patched:
        patched.setattr(manifest, "_move", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            session.write_results(NEW)


def kept(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (folder / "results").iterdir()}


def temporaries(folder: Path) -> list[Path]:
    return [*folder.rglob(".*.new")]


KILLED = """
import os, shutil, signal, sys
from pathlib import Path
from daq.session import Session

def die_at(number):
    calls = [0]
    def hook(real):
        def call(*given, **named):
            calls[0] += 1
            if calls[0] == number:
                os.kill(os.getpid(), signal.SIGKILL)
            return real(*given, **named)
        return call
    for name in ("open", "replace", "unlink"):
        setattr(os, name, hook(getattr(os, name)))
    os.fsync = hook(lambda _: None)  # the disk outlives the process

source, to, new = Path(sys.argv[1]), Path(sys.argv[2]), eval(sys.argv[3])
for number in range(1, 200):
    folder = to / f"{number:03d}"
    shutil.copytree(source, folder)
    child = os.fork()
    if not child:
        session = Session.open(folder)
        die_at(number)
        session.write_results(new)
        os._exit(0)
    if os.waitpid(child, 0)[1] == 0:
        print(number)
        break
"""


@pytest.mark.slow
@posix_only
def test_a_change_that_is_killed_at_any_call_is_whole_or_not_at_all(session: Session, tmp_path: Path) -> None:
    """The process gets SIGKILL before each call by which the change opens, syncs, moves or removes a file, in turn."""
    killed = tmp_path / "killed"
    killed.mkdir()
    command = [sys.executable, "-c", KILLED, str(session.folder), str(killed), repr(NEW)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=True)
    moments = int(done.stdout)
    assert moments > 20  # three contents and a manifest, each opened, synced and moved
    cut_off = [folder for folder in sorted(killed.iterdir()) if not verify(folder).ok]
    assert len(cut_off) >= len(NEW)
    for folder in cut_off:
        assert all("recover the session" in problem for problem in verify(folder).problems)
    waiting = unsealed_sessions(killed)
    assert set(cut_off) <= set(waiting)
    completed = {folder: recover(folder).completed for folder in waiting}
    assert all(completed[folder] for folder in cut_off)
    ended = {True: 0, False: 0}
    for folder in killed.iterdir():
        assert verify(folder).ok
        assert kept(folder) in (OLD, NEW)
        assert not temporaries(folder)
        ended[kept(folder) == NEW] += 1
    assert min(ended.values()) > 5
    assert unsealed_sessions(killed) == ()


@posix_only
def test_the_next_change_completes_one_that_was_cut_off(
    session: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    change_cut_off(session, monkeypatch)
    assert not verify(session.folder).ok
    Session.open(session.folder).write_result("more.json", "{}")
    assert verify(session.folder).ok
    assert kept(session.folder) == NEW | {"more.json": b"{}"}


@posix_only
def test_whoever_looks_waits_for_a_change_of_another_process(
    session: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    change_cut_off(session, monkeypatch)
    found = list[Verification]()
    watcher = Thread(target=lambda: found.append(verify(session.folder)))
    with Lock(session.folder):
        watcher.start()
        watcher.join(0.5)
        assert not found
        manifest.complete(session.folder)
    watcher.join()
    assert found[0].ok


WRITER = """
import sys
from daq.session import Session
for number in range(10):
    session = Session.open(sys.argv[1])
    session.write_results({"both.json": sys.argv[2] * 1000, f"{sys.argv[2]}{number}.json": "{}"})
    session.update(remarks=f"{sys.argv[2]} {number}")
"""


@posix_only
def test_two_processes_that_write_at_once_lose_nothing(session: Session) -> None:
    writers = [
        subprocess.Popen(
            [sys.executable, "-c", WRITER, str(session.folder), name],
            cwd=ROOT,
            stderr=subprocess.PIPE,
            text=True,
        )
        for name in "ab"
    ]
    found = []
    while any(writer.poll() is None for writer in writers):
        found.append(verify(session.folder))
    said = [writer.communicate(timeout=60)[1] for writer in writers]
    assert [writer.returncode for writer in writers] == [0, 0], said
    assert not [
        problem for one in found for problem in one.problems
    ]  # whoever looks meanwhile sees no damage
    result = verify(session.folder)
    assert result.ok
    assert result.remarks == ()
    assert len(kept(session.folder)) == len(OLD) + 1 + 2 * 10
    assert not temporaries(session.folder)


def test_a_change_based_on_what_another_has_changed_is_refused_and_writes_nothing(session: Session) -> None:
    seen = digest(OLD["ladder.json"])
    session.write_results({"ladder.json": "mine"}, seen={"ladder.json": seen})
    before = kept(session.folder)
    for stale in (seen, None):
        with pytest.raises(SessionChanged, match=r"another program has changed .*ladder\.json") as refused:
            session.write_results(
                {"ladder.json": "yours", "model.json": "yours"}, seen={"ladder.json": stale}
            )
        assert refused.value.exit_code == 9
    assert kept(session.folder) == before
    assert verify(session.folder).ok


def test_metadata_that_another_process_changed_meanwhile_are_kept(session: Session) -> None:
    mine, yours = Session.open(session.folder), Session.open(session.folder)
    mine.update(operator="Ada")
    yours.update(specimen="the new spring")
    info = Session.open(session.folder).info
    assert (info.operator, info.specimen) == ("Ada", "the new spring")


def test_a_session_that_another_process_holds_is_not_written(
    session: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    from daq import session_folder

    monkeypatch.setattr(session_folder, "WAIT_S", 0.05)
    lock = Lock(session.folder)
    lock.acquire()
    try:
        with pytest.raises(SessionLocked, match="nothing was changed") as refused:
            session.write_results(NEW)
        assert refused.value.exit_code == 9
    finally:
        lock.release()
    assert kept(session.folder) == OLD


def test_many_writers_of_one_file_leave_one_whole_content(tmp_path: Path) -> None:
    contents = [bytes([65 + number]) * 100_000 for number in range(8)]
    failed = []

    def write(data: bytes) -> None:
        try:
            for _ in range(5):
                write_whole(tmp_path / "table.csv", data)
        except StorageError as error:
            failed.append(error)

    threads = [Thread(target=write, args=(data,)) for data in contents]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failed
    assert (tmp_path / "table.csv").read_bytes() in contents
    assert [path.name for path in tmp_path.iterdir()] == ["table.csv"]


@posix_only
@pytest.mark.parametrize("kind", ["pipe", "link", "socket"])
def test_what_is_no_file_in_place_of_the_lock_neither_hangs_nor_makes_a_file(
    session: Session, tmp_path: Path, kind: str
) -> None:
    import socket

    outside, lock = tmp_path / "outside", session.folder / ".lock"
    if kind == "pipe":
        os.mkfifo(lock)
    elif kind == "link":
        lock.symlink_to(outside)
    else:
        made = socket.socket(socket.AF_UNIX)
        os.chdir(session.folder)  # the path of a socket is short
        made.bind(".lock")
        os.chdir(ROOT)
        made.close()
    (session.folder / "manifest.json").unlink()
    assert unsealed_sessions(session.folder.parent) == (session.folder,)
    for change in (lambda: recover(session.folder), lambda: session.write_results(NEW)):
        with pytest.raises(StorageError, match="no plain file"):
            change()
    assert not outside.exists()
    assert kept(session.folder) == OLD


@posix_only
def test_a_linked_folder_and_a_pipe_are_found_by_verify(session: Session, tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (session.folder / "extra").symlink_to(tmp_path / "elsewhere")
    (session.results / "more").symlink_to(tmp_path / "elsewhere")
    os.mkfifo(session.results / "pipe.json")
    problems = verify(session.folder).problems
    for name in ("extra", "results/more", "results/pipe.json"):
        assert any(problem.startswith(f"{name}: no plain file") for problem in problems)
    shutil.move(session.results, tmp_path / "moved")
    session.results.symlink_to(tmp_path / "moved")
    assert any(problem.startswith("results: no plain file") for problem in verify(session.folder).problems)


@posix_only
def test_a_result_that_is_a_link_is_neither_read_nor_followed(session: Session, tmp_path: Path) -> None:
    secret = tmp_path / "secret"
    secret.write_text("secret")
    (session.results / "ladder.json").unlink()
    (session.results / "ladder.json").symlink_to(secret)
    with pytest.raises(StorageError, match="no plain file"):
        session.read_result("ladder.json", 1000)
    session.write_results(NEW)
    assert secret.read_text() == "secret"
    assert kept(session.folder) == NEW


def test_a_session_that_lost_its_manifest_is_mended_with_the_folder(session: Session) -> None:
    (session.folder / "manifest.json").unlink()
    assert unsealed_sessions(session.folder.parent) == (session.folder,)
    assert recover(session.folder).info.state is State.RECOVERED
    assert verify(session.folder).ok
    assert unsealed_sessions(session.folder.parent) == ()


SEALED = """
import os, signal, sys
import numpy as np
from daq import session_folder
from daq.recording import Channel, Recording
from daq.session import Session

real = os.replace
def replace(source, to):
    real(source, to)
    if os.path.basename(to) == "manifest.json":
        os.kill(os.getpid(), signal.SIGKILL)

os.replace = replace
samples = np.sin(np.arange(64) / 5.0)[np.newaxis]
recording = Recording(64.0, (Channel("u", "displacement", "m"),), samples, np.ones(64, dtype=bool))
Session.create_imported(sys.argv[1], recording, None)
"""


@posix_only
def test_a_session_killed_between_manifest_and_metadata_is_sealed_by_recover(tmp_path: Path) -> None:
    folder = tmp_path / "s"
    killed = subprocess.run([sys.executable, "-c", SEALED, str(folder)], cwd=ROOT, timeout=60, check=False)
    assert killed.returncode == -signal.SIGKILL
    assert unsealed_sessions(tmp_path) == (folder,)
    assert recover(folder).info.state is State.SEALED
    assert verify(folder).ok


def test_a_strangers_leftover_does_not_replace_the_raw_log(session: Session) -> None:
    from daq.manifest import read_manifest, write_manifest
    from daq.storage import staged

    raw, forged = session.folder / "raw.log", b"forged"
    before = raw.read_bytes()
    staged(raw, digest(forged)).write_bytes(forged)
    write_manifest(session.folder, read_manifest(session.folder).with_files({"raw.log": forged}))
    recover(session.folder)
    assert raw.read_bytes() == before
    assert not temporaries(session.folder)


def test_of_many_who_make_the_same_session_at_once_one_makes_it_whole(tmp_path: Path) -> None:
    samples = np.sin(np.arange(64) / 5.0)[np.newaxis]
    recording = Recording(64.0, (Channel("u", "displacement", "m"),), samples, np.ones(64, dtype=bool))
    for attempt in range(4):
        folder, ended = tmp_path / str(attempt), []
        start = Barrier(4)

        def make(folder: Path = folder, ended: list[str] = ended, start: Barrier = start) -> None:
            start.wait()
            try:
                Session.create_imported(folder, recording, None)
                ended.append("made")
            except (OperatorError, SessionLocked) as error:
                ended.append(type(error).__name__)

        threads = [Thread(target=make) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert ended.count("made") == 1
        assert len(ended) == 4
        assert verify(folder).ok
