"""The manifest of a session: a checksum of every file, counts, gaps and verdict, and a checksum of itself.

New contents of a sealed session and the manifest that names them are one change. First the contents are written beside
their files, under names that hold their checksums. Then the manifest is replaced: from that moment the change counts.
Last the contents are moved into their places. A process that dies before the manifest leaves the session as it was; one
that dies after it leaves what `complete` moves, so that no journal beside the manifest is needed. Whoever changes a
session holds the lock of the folder.
"""

import json
import os
import re
import stat
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from daq.errors import NotASession, SessionDamaged, StationError
from daq.plain_text import first_fault
from daq.quality import Verdict
from daq.raw_log import MAX_LOG
from daq.recording import Gap
from daq.sensor_faults import FlaggedRun
from daq.session_info import State
from daq.storage import (
    LOCK,
    TEMPORARY,
    WAIT_S,
    Lock,
    digest,
    read_regular,
    refused,
    staged,
    sync_directory,
    write_new,
    write_whole,
)

NAME = "manifest.json"
MAX_MANIFEST = 1 << 24
_TEMPORARY = re.compile(rf"\.(.+)\.[0-9a-f]{{16,64}}{re.escape(TEMPORARY)}")
CUT_OFF = "its change was cut off half-way; recover the session"


class FileEntry(BaseModel):
    """What a file was when it was written."""

    model_config = ConfigDict(frozen=True)

    size: int = Field(ge=0)
    sha256: str = Field(pattern="^[0-9a-f]{64}$")


class Counts(BaseModel):
    """Samples of the recording, and what the wire did to get them; zero where it does not apply."""

    model_config = ConfigDict(frozen=True)

    samples: int = 0
    lost: int = 0
    planned: int = 0
    resent: int = 0
    frames: int = 0
    damaged_frames: int = 0
    duplicates: int = 0


class Manifest(BaseModel):
    """What `manifest.json` holds; `files` by path relative to the session's folder."""

    model_config = ConfigDict(frozen=True)

    format: int = Field(default=1, ge=1, le=1)
    state: State
    files: dict[str, FileEntry]
    counts: Counts = Counts()
    gaps: tuple[Gap, ...] = ()
    flags: tuple[FlaggedRun, ...] = ()
    verdict: Verdict | None = None

    def to_bytes(self) -> bytes:
        """Return the one way in which this manifest is written; its last entry is its own checksum.

        Without flags it is written as manifests were before there were any.
        """
        content = self.model_dump(mode="json", exclude=None if self.flags else {"flags"})
        plain = json.dumps(content, indent=1, sort_keys=True).encode()
        return json.dumps({**content, "sha256": digest(plain)}, indent=1, sort_keys=True).encode() + b"\n"

    def with_files(self, contents: Mapping[str, bytes]) -> "Manifest":
        """Return a copy in which these files have these contents."""
        changed = {name: entry(data) for name, data in contents.items()}
        return self.model_copy(update={"files": {**self.files, **changed}})


@dataclass(frozen=True)
class Verification:
    """What `verify` found: `problems` in words (none when all is as it was written), `files` checked."""

    folder: Path
    problems: tuple[str, ...]
    files: int
    remarks: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether everything is as it was written."""
        return not self.problems


def entry(data: bytes) -> FileEntry:
    """Return the manifest's entry for a file."""
    return FileEntry(size=len(data), sha256=digest(data))


def read_manifest(folder: Path) -> Manifest:
    """Read and check the manifest; NotASession when there is none, SessionDamaged when it was altered."""
    data = read_regular(folder / NAME, MAX_MANIFEST)
    try:
        manifest = Manifest.model_validate_json(data)
    except ValidationError as error:
        raise SessionDamaged(f"{folder / NAME}: no manifest any more ({first_fault(error)})") from error
    if manifest.to_bytes() != data:
        raise SessionDamaged(f"{folder / NAME}: its own checksum does not agree; it was altered")
    return manifest


def known_manifest(folder: Path) -> Manifest | None:
    """Read the manifest, None when there is none; SessionDamaged when it was altered."""
    try:
        return read_manifest(folder)
    except NotASession:
        return None


def write_manifest(folder: Path, manifest: Manifest) -> None:
    """Write the manifest as a whole."""
    write_whole(folder / NAME, manifest.to_bytes())


def commit(folder: Path, contents: Mapping[str, bytes], manifest: Manifest) -> None:
    """Give files of a session new contents, by name relative to `folder`, and the manifest that names them.

    StorageError when the disk refuses; as long as it refuses the contents or the manifest, nothing is changed.
    """
    try:
        for name, data in contents.items():
            temporary = staged(folder / name, digest(data))
            try:
                temporary.unlink(missing_ok=True)  # of a process that died
            except OSError as error:
                raise refused(temporary, error) from error
            write_new(temporary, data, folder / name)
        for parent in {(folder / name).parent for name in contents}:
            sync_directory(parent)
        write_manifest(folder, manifest)
    finally:
        complete(folder)


def complete(folder: Path) -> tuple[str, ...]:
    """Move the contents of a change that was cut off into their places, and remove what belongs to none.

    Return the names that were moved. SessionDamaged when the manifest was altered, StorageError when the disk refuses.
    """
    moved = []
    leftovers = list(_leftovers(folder))
    manifest = known_manifest(folder) if leftovers else None
    for temporary, path in leftovers:
        name = path.relative_to(folder).as_posix()
        known = manifest.files.get(name) if manifest is not None and _changes(name) else None
        if known is not None and temporary == staged(path, known.sha256) and _holds(temporary, known.sha256):
            _move(temporary, path)
            moved.append(name)
        else:
            with suppress(OSError):
                temporary.unlink()
    return tuple(moved)


def is_cut_off(folder: Path) -> bool:
    """Check whether a process that died has left anything of a change."""
    return next(_leftovers(folder), None) is not None


def _leftovers(folder: Path) -> Iterator[tuple[Path, Path]]:
    """Yield each temporary file of a session, and the file whose content it was to become."""
    for top, folders, files in os.walk(folder):
        folders[:] = [name for name in folders if not name.startswith(".")]
        for name in files:
            if found := _TEMPORARY.fullmatch(name):
                yield Path(top) / name, Path(top) / found[1]


def _changes(name: str) -> bool:
    """Check whether a file may ever change: the raw log and the source never do."""
    return name.startswith("results/") or ("/" not in name and name != "raw.log")


def _holds(temporary: Path, sha256: str) -> bool:
    try:
        return digest(read_regular(temporary, MAX_LOG)) == sha256
    except StationError:
        if temporary.is_file() and not temporary.is_symlink():
            raise  # the disk refuses to read what belongs to the change: it must stay
        return False


def _move(temporary: Path, path: Path) -> None:
    try:
        os.replace(temporary, path)
    except OSError as error:
        raise refused(path, error) from error
    sync_directory(path.parent)


def verify(folder: Path) -> Verification:
    """Compare every file of a session with the manifest; finds one flipped bit anywhere.

    Plain files in `results` that the manifest does not know are remarks; elsewhere they are problems, as links,
    pipes and devices are everywhere. A change by another process is waited for, WAIT_S at most.
    Never raises for what is in the folder.
    """
    found = _verify_once(folder)
    if found.ok or not os.path.lexists(folder / NAME):
        return found
    with suppress(StationError), Lock(folder, WAIT_S):  # where nothing can be written, nobody changes it
        found = _verify_once(folder)
    return found


def _verify_once(folder: Path) -> Verification:
    try:
        manifest = read_manifest(folder)
    except NotASession:
        return Verification(folder, (f"{folder}: not sealed, or no session; recover it first",), 0)
    except StationError as error:
        return Verification(folder, (str(error),), 0)
    problems = [p for name, known in manifest.files.items() if (p := _compare(folder, name, known))]
    remarks: list[str] = []
    for name in session_files(folder):
        if name in manifest.files:
            continue
        if not _is_plain(folder / name):
            problems.append(f"{name}: no plain file, but a link, a pipe or the like; remove it")
        else:
            (remarks if name.startswith("results/") else problems).append(f"{name}: not in the manifest")
    return Verification(folder, tuple(problems), len(manifest.files) + 1, tuple(remarks))


def _compare(folder: Path, name: str, known: FileEntry) -> str:
    if not is_plain_name(name):
        return f"{name!r}: the manifest names a file outside the session"
    wrong = _differs(folder / name, known)
    if wrong and not _differs(staged(folder / name, known.sha256), known):
        return f"{name}: {CUT_OFF}"
    wrong = wrong and _differs(folder / name, known)  # another process may have moved it there in between
    return f"{name}: {wrong}" if wrong else ""


def _differs(path: Path, known: FileEntry) -> str:
    """Return in words how a file differs from what was written; empty when it does not."""
    try:
        data = read_regular(path, min(max(known.size, 1), MAX_LOG))
    except StationError as error:
        return str(error).removeprefix(str(path)).strip(": ")
    if len(data) != known.size:
        return f"{len(data)} bytes, but {known.size} were written"
    return "" if digest(data) == known.sha256 else "its checksum does not agree; it was altered"


def is_plain_name(name: str) -> bool:
    """Check whether a relative path stays in its folder, on any system."""
    parts = name.replace("\\", "/").split("/")
    return len(name) < 256 and all(p not in ("", ".", "..") and ":" not in p and "\0" not in p for p in parts)


def session_files(folder: Path) -> list[str]:
    """Return the files of a session but the manifest, the lock and temporaries; linked folders count as files."""
    names = []
    for top, folders, files in os.walk(folder):
        linked = [name for name in folders if (Path(top) / name).is_symlink()]
        for file in (*files, *linked):
            path = Path(top) / file
            name = path.relative_to(folder).as_posix()
            passing = name == LOCK or (file.startswith(".") and file.endswith(TEMPORARY))
            if name != NAME and not (passing and _is_plain(path)):
                names.append(name)
    return sorted(names)


def _is_plain(path: Path) -> bool:
    try:
        return stat.S_ISREG(path.lstat().st_mode)
    except OSError:  # gone meanwhile
        return True
