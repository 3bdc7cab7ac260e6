"""Files that survive: whole or not at all, never overwritten by accident, locked while they are written."""

import errno
import hashlib
import os
import shutil
import stat
from contextlib import suppress
from pathlib import Path
from typing import IO

from daq.errors import NotASession, SessionExists, SessionLocked, StorageError

_BINARY = getattr(os, "O_BINARY", 0)
_NO_FOLLOW = getattr(os, "O_NOFOLLOW", 0)
_NO_WAIT = getattr(os, "O_NONBLOCK", 0)


def refused(path: Path, error: OSError) -> StorageError:
    """Return the error that says in words why the disk refused `path`."""
    if error.errno == errno.ENOSPC:
        return StorageError(f"{path}: the disk is full; free some space or name a folder on another disk")
    if error.errno in (errno.EACCES, errno.EPERM, errno.EROFS):
        return StorageError(f"{path}: not writable here ({error.strerror}); name another folder")
    return StorageError(f"{path}: {error.strerror or error}; check the disk or name another folder")


def make_folder(folder: Path) -> None:
    """Make a new folder for a session; SessionExists when it holds something already."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise SessionExists(
                f"{folder} holds something already; nothing was overwritten, name a new folder"
            )
    except FileExistsError as error:
        raise SessionExists(f"{folder} is a file; name a new folder for the session") from error
    except OSError as error:
        raise refused(folder, error) from error


def require_space(folder: Path, spare: int) -> None:
    """StorageError when the disk under `folder` (there or not yet) has less than `spare` bytes free."""
    place = folder.absolute()
    while not place.exists() and place != place.parent:
        place = place.parent
    try:
        free = shutil.disk_usage(place).free
    except OSError as error:
        raise refused(folder, error) from error
    if free < spare:
        raise StorageError(
            f"{place}: only {free / 1e6:.1f} MB are free and {spare / 1e6:.0f} MB may be needed;"
            " free some space or name a folder on another disk"
        )


def open_new(path: Path) -> int:
    """Open a file that must not exist yet for appending, and return its descriptor."""
    try:
        return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND | _BINARY, 0o644)
    except FileExistsError as error:
        raise SessionExists(f"{path} exists already; nothing was overwritten, name a new folder") from error
    except OSError as error:
        raise refused(path, error) from error


def read_regular(path: Path, limit: int) -> bytes:
    """Return the bytes of a plain file of at most `limit` bytes; links, pipes and devices are refused."""
    try:
        fd = os.open(path, os.O_RDONLY | _BINARY | _NO_FOLLOW | _NO_WAIT)
    except FileNotFoundError as error:
        raise NotASession(f"{path} is not there") from error
    except OSError as error:
        raise StorageError(f"{path} cannot be read: {error.strerror or error}") from error
    with os.fdopen(fd, "rb") as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode):
            raise StorageError(f"{path} is no plain file; a session holds plain files only")
        if status.st_size > limit:
            raise StorageError(f"{path} has {status.st_size} bytes, more than the {limit} that are sensible")
        try:
            return file.read()
        except OSError as error:
            raise StorageError(f"{path} cannot be read: {error.strerror or error}") from error


def write_whole(path: Path, data: bytes) -> None:
    """Write a file so that after any crash the old or the new content is there: temporary, sync, rename."""
    temporary = path.with_name(f".{path.name}.new")
    try:
        temporary.unlink(missing_ok=True)  # it may be a link to another place
        with temporary.open("xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except OSError as error:
        with suppress(OSError):
            temporary.unlink()
        raise refused(path, error) from error
    sync_directory(path.parent)


def sync_directory(folder: Path) -> None:
    """Force the names in a folder to the disk, where the system can."""
    with suppress(OSError):
        fd = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(fd)
        finally:
            os.close(fd)


def digest(data: bytes) -> str:
    """Return the checksum that the manifest keeps of a file (SHA-256, hexadecimal)."""
    return hashlib.sha256(data).hexdigest()


class Lock:
    """A lock on a folder that the system takes back when the process dies, however it dies."""

    NAME = ".lock"

    def __init__(self, folder: Path) -> None:
        self.path = folder / self.NAME
        self._file: IO[bytes] | None = None

    def acquire(self) -> None:
        """Take the lock at once or raise SessionLocked."""
        for _ in range(10):
            try:
                file = self.path.open("ab")
            except OSError as error:
                raise refused(self.path, error) from error
            try:
                _lock_file(file)
            except OSError as error:
                file.close()
                raise SessionLocked(
                    f"{self.path.parent} is being written by another process; wait for it to end"
                ) from error
            if self._is_current(file):
                self._file = file
                return
            file.close()
        raise SessionLocked(f"{self.path.parent} is being locked and unlocked by others; try again")

    def _is_current(self, file: IO[bytes]) -> bool:
        """Return whether nobody removed the lock's file between opening and locking it."""
        try:
            return os.path.samestat(os.fstat(file.fileno()), self.path.stat())
        except OSError:
            return False

    def release(self) -> None:
        """Give the lock back and remove its file; harmless when it is not held."""
        if self._file is not None:
            with suppress(OSError):
                self.path.unlink()
            self._file.close()
            self._file = None


def _lock_file(file: IO[bytes]) -> None:
    try:
        import fcntl
    except ImportError:
        import msvcrt

        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined,unused-ignore]
        return
    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
