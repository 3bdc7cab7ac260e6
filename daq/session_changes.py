"""One way to change a sealed session: new contents and the manifest that names them are one change.

First the contents are written beside their files, under names that hold their checksums. Then the manifest is
replaced: from that moment the change counts. Last the contents are moved into their places. A process that dies
before the manifest leaves the session as it was; one that dies after it leaves what `complete` moves, so that no
journal beside the manifest is needed. Whoever calls these functions holds the lock of the folder.
"""

import os
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path

from daq.errors import StationError
from daq.manifest import Manifest, known_manifest, write_manifest
from daq.raw_log import MAX_LOG
from daq.storage import TEMPORARY, digest, read_regular, refused, staged, sync_directory, write_new

_TEMPORARY = re.compile(rf"\.(.+)\.[0-9a-f]{{16,64}}{re.escape(TEMPORARY)}")


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
