"""Sessions as the operator names them: a folder, or a data file that becomes one on the way."""

import re
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from daq.errors import UnreadableFile
from daq.importing import read_file
from daq.importing.options import ImportOptions
from daq.recording import Gap, Recording
from daq.session import Session
from daq.session_info import SessionInfo
from identify.errors import NotIdentifiable
from identify.preprocessing.release import Release, find_releases
from station.exits import UsageProblem
from station.output import progress
from station.results.session_names import find_session
from station.story.preparation import Options, free_decay

MOST_RELEASES = 100


@dataclass(frozen=True, eq=False)
class Imported:
    """What an import made: the sessions, one for each release, and what was understood and guessed."""

    sessions: tuple[Session, ...]
    recording: Recording
    notes: tuple[str, ...]


def open_session(argument: str, sessions: Path, info: SessionInfo | None = None) -> Session:
    """Return the session that the operator means.

    `argument` is a session's folder, its name within `sessions` (or its beginning, or `last`: see
    `session_names`), or a data file, which is imported first (a second time it is opened, not imported
    again). Raises UsageProblem when it is none of these.
    """
    path = Path(argument)
    if path.is_dir():
        return Session.open(path)
    if path.is_file():
        known = _imported_before(path, sessions)
        if known is not None:
            return Session.open(known)
        return _import_on_the_way(path, sessions, info or SessionInfo())
    named = find_session(argument, sessions)
    if named is not None:
        return Session.open(named)
    raise UsageProblem(
        f"{argument}: there is no such session or data file (sessions are looked for in {sessions.resolve()})"
    )


def _import_on_the_way(file: Path, sessions: Path, info: SessionInfo) -> Session:
    try:
        imported = import_file(file, None, sessions, ImportOptions(), info)
    except UnreadableFile as error:
        raise UsageProblem(f"{error} (options as these belong to `station import {file}`)") from error
    for note in imported.notes:
        progress(f"{file.name}: {note}")
    first, *others = imported.sessions
    progress(f"imported as {first.folder}")
    for session in others:
        progress(f"another release of the file: {session.folder}")
    return first


def import_file(
    file: Path, folder: Path | None, sessions: Path, options: ImportOptions, info: SessionInfo
) -> Imported:
    """Read a file and make a session of each release in it.

    With one release the session is `folder`, or the file's name within `sessions`; with several, a number
    is added. Nothing is overwritten.
    """
    if not file.is_file():
        raise UsageProblem(f"{file}: there is no such file")
    recording = read_file(file, options)
    parts, notes = split(recording)
    first = folder or sessions / _free_name(file, sessions, len(parts))
    made = []
    for number, part in enumerate(parts, start=1):
        where = first if len(parts) == 1 else first.with_name(f"{first.name}_{number}")
        known = info.model_copy(update={"name": where.name})
        made.append(Session.create_imported(where, part, file, known))
    return Imported(tuple(made), recording, (*recording.notes, *notes))


def _free_name(file: Path, sessions: Path, parts: int) -> str:
    stem = _stem(file)
    name, number = stem, 1
    while (sessions / name).exists() or (parts > 1 and (sessions / f"{name}_1").exists()):
        number += 1
        name = f"{stem}-{number}"
    return name


def _imported_before(file: Path, sessions: Path) -> Path | None:
    """Return the session that was made of this very file, with nothing but defaults, if there is one."""
    if not sessions.is_dir():
        return None
    content = file.read_bytes()
    for folder in sorted(sessions.glob(f"{_stem(file)}*")):
        copy = folder / "source" / file.name
        if copy.is_file() and copy.read_bytes() == content:
            return folder
    return None


def _stem(file: Path) -> str:
    return re.sub(r"[^\w.-]+", "_", file.stem).strip("._") or "recording"


def split(recording: Recording) -> tuple[list[Recording], tuple[str, ...]]:
    """Cut a recording into one for each release; the notes say what was found."""
    decay = free_decay(recording, Options())
    if decay.driven:
        return [recording], ("a force drives the motion to the end: no free decay, and so one session",)
    try:
        releases = find_releases(
            decay.rate, decay.displacement, decay.velocity, decay.acceleration, decay.valid
        )
    except NotIdentifiable as refusal:
        return [recording], (f"no release found: {refusal}",)
    if len(releases) < 2:
        return [recording], ()
    if len(releases) > MOST_RELEASES:
        return [recording], (
            f"{len(releases)} beginnings of a motion found, too many to be releases: one session",
        )
    starts = [0, *(_begin(before, after) for before, after in pairwise(releases))]
    stops = [*starts[1:], recording.samples.shape[1]]
    note = f"{len(releases)} releases found: each becomes a session"
    return [cut(recording, start, stop) for start, stop in zip(starts, stops, strict=True)], (note,)


def _begin(before: Release, after: Release) -> int:
    """Return where the record of a release begins: with its rest, after the motion before it."""
    if after.rest[1] > after.rest[0]:
        return max(after.rest[0], min(before.end, after.rest[1] - 1))
    return max(before.end, before.index + 1)


def cut(recording: Recording, start: int, stop: int) -> Recording:
    """Return samples `start` to `stop` - 1 as a recording of its own."""
    gaps = []
    for gap in recording.gaps:
        first, last = max(gap.first, start), min(gap.first + gap.count, stop)
        if last > first:
            gaps.append(Gap(first - start, last - first, gap.reason))
    return Recording(
        recording.rate,
        recording.channels,
        recording.samples[:, start:stop],
        recording.valid[start:stop],
        tuple(gaps),
        recording.rate_std,
        None,
        (*recording.notes, f"samples {start} to {stop - 1} of the file"),
    )
