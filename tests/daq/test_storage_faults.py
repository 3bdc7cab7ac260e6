"""A fault at every call by which an import, a capture, a change and a recovery reach the disk."""

import os
import shutil
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from failing_disk import FAULTS, FailingDisk, Killed

from daq.errors import StationError
from daq.failover import SessionWriter
from daq.import_log import import_log
from daq.raw_log import Kind, RawLog, unpack
from daq.recording import Channel, Recording
from daq.session import Session, recover, unsealed_sessions, verify
from daq.session_info import SessionInfo, State

RATE, COUNT = 256.0, 600
BEFORE, AFTER = {"a.json": b"old", "b.json": b"old too"}, {"a.json": b"new", "b.json": b"new too"}
NUMBER_OF_CALLS = 400
"""More than any of these needs; a loop that never passes ends here."""

OF_THE_DISK = [pytest.param(name, marks=[] if name == "EIO" else [pytest.mark.slow]) for name in FAULTS]


@pytest.fixture(scope="module")
def recording() -> Recording:
    t = np.arange(COUNT) / RATE
    samples = np.vstack([0.02 * np.cos(25 * t), -12.5 * np.cos(25 * t)])
    channels = (Channel("u", "displacement", "m"), Channel("a", "acceleration", "m/s^2"))
    return Recording(RATE, channels, samples, np.ones(COUNT, dtype=bool))


def every_call(
    fault: str,
    tmp_path: Path,
    run: Callable[[Path], object],
    prepare: Callable[[Path], object] = lambda _: None,
) -> Iterator[tuple[Path, object]]:
    """Fail `run` at its first call, its second ... until it passes; yield the folder and what it returned or raised."""
    for at in range(1, NUMBER_OF_CALLS):
        folder = tmp_path / f"{fault}{at}"
        folder.mkdir()
        prepare(folder)
        disk = FailingDisk(at, fault)
        ended: object
        if fault in ("killed", "memory"):
            died = death_in(disk, lambda where=folder: run(where))
            if died is None:
                assert at > 10, "hardly any call was counted"
                return
            yield folder, died
            shutil.rmtree(folder, ignore_errors=True)
            continue
        with disk.used():
            try:
                ended = run(folder)
            except StationError as error:
                ended = error
        yield folder, ended
        if not disk.failed:
            assert at > 10, "hardly any call was counted"
            return
        shutil.rmtree(folder, ignore_errors=True)
    raise AssertionError("it never passed")


def death_in(disk: FailingDisk, run: Callable[[], object]) -> BaseException | None:
    """Let a process of its own run until it ends, so that its locks go with it; None when it passed."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that a process with threads forks
        child = os.fork()
    if child == 0:
        code = 1
        try:
            with disk.used():
                run()
            code = 0
        except Killed:
            code = 9
        except (MemoryError, StationError):
            code = 7
        finally:
            os._exit(code)
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return {0: None, 7: MemoryError(), 9: Killed()}[code]


def whole(folder: Path) -> Session:
    """Open a session that claims to be whole: nothing of it may be wrong."""
    found = verify(folder)
    assert found.ok, found.problems
    assert not list(folder.rglob("*.new"))
    return Session.open(folder)


def prefix(session: Session, sent: Recording) -> int:
    """How many samples are kept; each as it was sent, in its place."""
    kept = session.recording()
    assert kept.valid.all()
    count = kept.samples.shape[1]
    np.testing.assert_array_equal(kept.samples, sent.samples[:, :count])
    return count


@pytest.mark.parametrize("fault", OF_THE_DISK)
def test_an_import_is_whole_or_absent(fault: str, tmp_path: Path, recording: Recording) -> None:
    source = tmp_path / "source.csv"
    source.write_bytes(b"1,2\n" * 1000)
    for folder, ended in every_call(
        fault, tmp_path, lambda f: Session.create_imported(f / "s", recording, source)
    ):
        s = folder / "s"
        if isinstance(ended, Session):
            assert prefix(whole(s), recording) == COUNT
            assert (s / "source" / "source.csv").read_bytes() == source.read_bytes()
        elif not isinstance(ended, Killed):
            assert not s.exists(), f"{ended}: {list(s.rglob('*'))}"
        elif (s / "raw.log").exists() and (s / "raw.log").stat().st_size > 17:
            assert s in unsealed_sessions(folder) or whole(s).info.state is State.SEALED
            recovered = recover(s)
            if recovered.info.verdict != "REJECT":
                assert prefix(whole(s), recording) == COUNT
        else:
            assert not (s / "manifest.json").exists()


def captured(folder: Path, pieces: list[bytes], spare: bool) -> Session:
    """As a capture writes: the log in the folder piece by piece, and in the spare place where the disk refuses."""
    log = RawLog()
    places = iter([folder / "spare1", folder / "spare2"])
    writer = SessionWriter.begin(
        folder / "s", SessionInfo(), log, (lambda _: next(places, None)) if spare else (lambda _: None), 0
    )
    for piece in pieces:
        log.append(Kind.RECEIVED, piece)
        log.sync()
    return writer.finish(State.SEALED, "", {})


@pytest.mark.parametrize(
    ("fault", "spare"),
    [
        ("EIO", False),
        ("EIO", True),
        pytest.param("full", False, marks=pytest.mark.slow),
        pytest.param("full", True, marks=pytest.mark.slow),
        pytest.param(
            "memory", False, marks=pytest.mark.slow
        ),  # no fault of the disk: the spare place is not asked for
        pytest.param("killed", False, marks=pytest.mark.slow),
    ],
)
def test_a_capture_keeps_all_that_was_written_before_the_fault(
    fault: str, spare: bool, tmp_path: Path, recording: Recording
) -> None:
    pieces = [r.payload for r in unpack(import_log(recording).data).records if r.kind is Kind.RECEIVED]
    data = b"".join(pieces)
    pieces = [data[i : i + 4000] for i in range(0, len(data), 4000)]
    for folder, ended in every_call(fault, tmp_path, lambda f: captured(f, pieces, spare)):
        logs = [log for log in folder.rglob("raw.log") if log.stat().st_size > 17]
        received = [
            b"".join(r.payload for r in unpack(log.read_bytes()).records if r.kind is Kind.RECEIVED)
            for log in logs
        ]
        assert all(data.startswith(kept) for kept in received)
        if isinstance(ended, Session):
            assert prefix(whole(ended.folder), recording) == COUNT
            assert data in received
        elif spare and fault == "EIO":
            raise AssertionError(f"one fault, a place to spare, and no session: {ended!r}")
        for log in logs:
            if log.parent in unsealed_sessions(folder):
                recover(log.parent)
            if Session.open(log.parent).info.state is not State.ABORTED:
                whole(log.parent)


@pytest.mark.parametrize("fault", OF_THE_DISK)
def test_a_change_of_two_results_happens_or_does_not(
    fault: str, tmp_path: Path, recording: Recording
) -> None:
    kept = tmp_path / "kept"
    Session.create_imported(kept, recording, None).write_results(BEFORE)

    def change(folder: Path) -> str:
        Session.open(folder / "s").write_results(AFTER)
        return "changed"

    for folder, ended in every_call(fault, tmp_path, change, lambda f: shutil.copytree(kept, f / "s")):
        s = folder / "s"
        if not isinstance(ended, str):
            recover(s)
        now = {name: (s / "results" / name).read_bytes() for name in BEFORE}
        assert now in ((AFTER,) if isinstance(ended, str) else (BEFORE, AFTER))
        assert prefix(whole(s), recording) == COUNT


@pytest.mark.parametrize("fault", OF_THE_DISK)
def test_a_recovery_that_fails_can_be_done_again(fault: str, tmp_path: Path, recording: Recording) -> None:
    def cut_off(folder: Path) -> None:
        session = Session.create(folder / "s", SessionInfo(state=State.RECORDING), import_log(recording))
        session.release()

    for folder, _ in every_call(fault, tmp_path, lambda f: recover(f / "s"), cut_off):
        raw = (folder / "s" / "raw.log").read_bytes()
        assert recover(folder / "s").info.state is State.RECOVERED
        assert prefix(whole(folder / "s"), recording) == COUNT
        assert (folder / "s" / "raw.log").read_bytes() == raw
