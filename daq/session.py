"""A session: a folder with the raw bytes (the truth), what they mean (metadata) and what was made of them.

session.json    metadata, and the state: recording, sealed, recovered, aborted
raw.log         every byte as it came, see `raw_log`
source/         for an import, a copy of the file
recipe.toml     for an import, how the file was read
results/        derived, can be made again
manifest.json   checksums, counts, gaps, verdict
.lock           while a process writes the session
.NAME.MARK.new  the content of NAME that waits until the manifest names it, see `manifest`

Here sessions are listed, and made whole when the program that wrote them was killed.
"""

import os
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from daq.errors import NotASession, SessionDamaged, SessionLocked, StationError, StorageError
from daq.manifest import NAME as MANIFEST, complete, is_cut_off, verify as verify
from daq.raw_log import MAX_LOG, Kind, Record, unpack
from daq.session_folder import Session as Session, make_inner
from daq.session_info import SessionInfo as SessionInfo, State as State
from daq.session_reading import INFO, RAW, read_info
from daq.storage import Lock, read_regular, refused

_UNSEALED = "the program ended before the session was sealed"


@dataclass(frozen=True)
class SessionSummary:
    """One line of a list of sessions; `problem` says why a folder cannot be read."""

    folder: Path
    info: SessionInfo | None
    problem: str = ""


def list_sessions(folder: Path | str) -> tuple[SessionSummary, ...]:
    """Return the sessions in a folder, oldest first; reads only `session.json` of each."""
    found = []
    try:
        with os.scandir(folder) as entries:
            names = sorted(item.name for item in entries if item.is_dir(follow_symlinks=False))
    except OSError as error:
        raise refused(Path(folder), error) from error
    for name in names:
        path = Path(folder) / name
        try:
            found.append(SessionSummary(path, read_info(path)))
        except NotASession:
            if (path / RAW).exists():
                found.append(SessionSummary(path, None, f"no {INFO}; recover it"))
        except StationError as error:
            found.append(SessionSummary(path, None, str(error)))
    return tuple(sorted(found, key=lambda s: (s.info.created.timestamp() if s.info else 0.0, s.folder.name)))


def unsealed_sessions(folder: Path | str) -> tuple[Path, ...]:
    """Return the sessions in a folder that a program left unfinished and that none is writing.

    These were never sealed, or have no manifest, or hold a change that was cut off.
    """
    waiting = []
    for summary in list_sessions(folder):
        if not _is_unfinished(summary.folder):
            continue
        try:
            with Lock(summary.folder):
                unfinished = _is_unfinished(summary.folder)  # and was not just being changed
        except SessionLocked:
            continue
        except StorageError:  # `recover` says why
            unfinished = True
        if unfinished:
            waiting.append(summary.folder)
    return tuple(waiting)


def _is_unfinished(folder: Path) -> bool:
    try:
        recording = read_info(folder).state is State.RECORDING
    except StationError:
        recording = True
    return recording or not os.path.lexists(folder / MANIFEST) or is_cut_off(folder)


def finish_change(folder: Path) -> tuple[str, ...]:
    """Complete a change that a process left half-way; return the files that it changed. Errors as `recover`."""
    if not is_cut_off(folder):
        return ()
    with Lock(folder):
        return complete(folder)


def recover(folder: Path | str) -> Session:
    """Make an unfinished session whole: everything up to the last whole record of its raw log.

    A change of results that was cut off is completed: see `completed` of what is returned. A sealed or recovered
    session is otherwise returned as it is. SessionLocked while a process writes it, NotASession or SessionDamaged
    when there is no raw log. The raw log itself is never touched.
    """
    folder = Path(folder)
    if not (folder / RAW).exists():
        raise NotASession(f"{folder}: there is no {RAW} in it, so there is nothing to recover")
    lock = Lock(folder)
    with lock:
        completed = complete(folder)
        raw = unpack(read_regular(folder / RAW, MAX_LOG))
        info = _info_again(folder, raw.records)
        session = Session(folder, info, lock, completed)
        if info.state in (State.SEALED, State.RECOVERED) and os.path.lexists(folder / MANIFEST):
            session.release()
            return session
        make_inner(session.results)
        lost = "the manifest was missing" if info.state is State.SEALED else _UNSEALED
        what = info.reason or lost
        session.seal(State.RECOVERED, f"{what}; {len(raw.records)} records recovered, {raw.cut} bytes cut")
        return session


def _info_again(folder: Path, records: tuple[Record, ...]) -> SessionInfo:
    """Read the metadata, from the raw log where `session.json` is gone or damaged."""
    try:
        return read_info(folder)
    except (NotASession, SessionDamaged):
        for record in records:
            note = record.note() if record.kind is Kind.NOTE else {}
            if note.get("event") == "session":
                try:
                    return SessionInfo.model_validate(note.get("info"))
                except ValidationError:
                    break
    return SessionInfo(name=folder.name)
