"""Files that survive: whole or not at all, never overwritten by accident, locked while they are written."""

import errno
import hashlib
import os
import secrets
import shutil
import stat
import time
from contextlib import suppress
from pathlib import Path
from typing import IO

from daq.errors import NotASession, NotWritable, OperatorError, SessionLocked, StorageError

TEMPORARY, LOCK = ".new", ".lock"
LOOK_AGAIN_S = 0.02
WAIT_S = 10.0
"""What a change by another process may take."""
LONGEST_NAME = 150

_CAREFUL = sum(
    getattr(os, name, 0) for name in ("O_BINARY", "O_NOFOLLOW", "O_NONBLOCK", "O_NOCTTY", "O_CLOEXEC")
)


def refused(path: Path, error: OSError) -> StorageError:
    """Return the error that says in words why the disk refused `path`."""
    if error.errno == errno.ENOSPC:
        return StorageError(f"{path}: the disk is full; free some space or name a folder on another disk")
    if error.errno in (errno.EACCES, errno.EPERM, errno.EROFS):
        if path.name == LOCK:
            return NotWritable(
                f"{path.parent}: this session may not be written ({error.strerror}); make it writable, or copy it elsewhere"
            )
        return NotWritable(f"{path}: not writable here ({error.strerror}); name another folder")
    return StorageError(f"{path}: {error.strerror or error}; check the disk or name another folder")


def make_folder(folder: Path) -> None:
    """Make a new folder for a session; OperatorError when it holds something already."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        require_empty(folder)
    except FileExistsError as error:
        raise OperatorError(f"{folder} is a file; name a new folder for the session") from error
    except OSError as error:
        raise refused(folder, error) from error


def discard(folder: Path) -> None:
    """Remove what a session that could not be made has left in its folder."""
    with suppress(OSError):
        for path in folder.iterdir():
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path, ignore_errors=True)
            else:
                with suppress(OSError):
                    path.unlink()


def require_empty(folder: Path) -> None:
    """OperatorError when a folder holds anything but a lock."""
    if any(path.name != LOCK for path in folder.iterdir()):
        raise OperatorError(f"{folder} holds something already; nothing was overwritten, name a new folder")


def require_space(folder: Path, spare: int) -> None:
    """StorageError when the disk under `folder` (there or not yet) has less than `spare` bytes free."""
    place = folder.absolute()
    place = next((one for one in (place, *place.parents) if one.exists()), place)
    try:
        free = shutil.disk_usage(place).free
    except OSError as error:
        raise refused(folder, error) from error
    if free < spare:
        raise StorageError(
            f"{place}: only {free / 1e6:.1f} MB are free and {spare / 1e6:.0f} MB may be needed;"
            " free some space or name a folder on another disk"
        )


def open_regular(path: Path, flags: int) -> int:
    """Open a plain file and return its descriptor; no link is followed, no pipe waited for, no device kept open.

    Raises OSError as the system does, and StorageError where there is something else of that name.
    """
    if not hasattr(os, "O_NOFOLLOW") and path.is_symlink():
        raise StorageError(_no_plain_file(path))
    try:
        fd = os.open(path, flags | _CAREFUL, 0o644)
    except OSError as error:
        if error.errno in (
            errno.ELOOP,
            errno.EMLINK,
            errno.ENXIO,
            errno.EISDIR,
        ):  # link, link, socket, folder
            raise StorageError(_no_plain_file(path)) from error
        raise
    if not stat.S_ISREG(os.fstat(fd).st_mode):
        os.close(fd)
        raise StorageError(_no_plain_file(path))
    return fd


def _no_plain_file(path: Path) -> str:
    return f"{path} is no plain file, but a link, a pipe or the like, and was not opened; remove it"


def open_new(path: Path) -> int:
    """Open a file that must not exist yet for appending, and return its descriptor."""
    try:
        return open_regular(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND)
    except FileExistsError as error:
        raise OperatorError(f"{path} exists already; nothing was overwritten, name a new folder") from error
    except OSError as error:
        raise refused(path, error) from error


def read_regular(path: Path, limit: int) -> bytes:
    """Return the bytes of a plain file of at most `limit` bytes; links, pipes and devices are refused."""
    try:
        fd = open_regular(path, os.O_RDONLY)
    except FileNotFoundError as error:
        raise NotASession(f"{path} is not there") from error
    except OSError as error:
        raise StorageError(f"{path} cannot be read: {error.strerror or error}") from error
    with os.fdopen(fd, "rb") as file:
        size = os.fstat(file.fileno()).st_size
        if size > limit:
            raise StorageError(f"{path} has {size} bytes, more than the {limit} that are sensible")
        try:
            return file.read(limit + 1)[:limit]
        except OSError as error:
            raise StorageError(f"{path} cannot be read: {error.strerror or error}") from error


def write_whole(path: Path, data: bytes) -> None:
    """Write a file so that after any crash, and with any other writer, one whole content is there."""
    temporary = staged(path, secrets.token_hex(16))
    write_new(temporary, data, path)
    try:
        os.replace(temporary, path)
    except OSError as error:
        with suppress(OSError):
            temporary.unlink()
        raise refused(path, error) from error
    sync_directory(path.parent)


def stored_name(name: str) -> str:
    """Return a file's name as it can be kept on any system and in the manifest: printable, UTF-8, not too long."""
    plain = "".join("_" if c in "\\/:" or not c.isprintable() else c for c in name)
    return plain.encode()[-LONGEST_NAME:].decode(errors="ignore")


def staged(path: Path, mark: str) -> Path:
    """Name the file in which content waits until it is moved: in the same folder, by 32 digits of its mark."""
    return path.with_name(f".{path.name}.{mark[:32]}{TEMPORARY}")


def write_new(temporary: Path, data: bytes, path: Path) -> None:
    """Write a file that must not be there yet and force it to the disk; `path` is what a refusal names."""
    try:
        fd = open_regular(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL)
    except OSError as error:
        raise refused(path, error) from error
    try:
        try:
            write_all(fd, data)
            os.fsync(fd)
        finally:
            os.close(fd)
    except OSError as error:
        with suppress(OSError):
            temporary.unlink()
        raise refused(path, error) from error


def write_all(fd: int, data: bytes) -> None:
    """Write all of `data` to an open file; OSError when the disk refuses."""
    view = memoryview(data)
    while view:
        view = view[os.write(fd, view) :]


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

    def __init__(self, folder: Path, wait_s: float = 0.2) -> None:
        self.path, self.wait_s = folder / LOCK, wait_s
        self._file: IO[bytes] | None = None

    def __enter__(self) -> None:
        self.acquire()

    def __exit__(self, *reason: object) -> None:
        self.release()

    def acquire(self) -> None:
        """Take the lock, within `wait_s` seconds where another has it, or raise SessionLocked."""
        until = time.monotonic() + self.wait_s
        while not self._taken():
            if time.monotonic() >= until:
                raise SessionLocked(
                    f"{self.path.parent} is being written by another process; nothing was changed, wait for it to end"
                )
            time.sleep(LOOK_AGAIN_S)

    def _taken(self) -> bool:
        """Try once: open, lock, and see whether what was locked is still the file of that name."""
        try:
            file = os.fdopen(open_regular(self.path, os.O_RDWR | os.O_CREAT), "r+b")
        except OSError as error:
            raise refused(self.path, error) from error
        try:
            _lock_file(file)
        except OSError as error:
            file.close()
            if error.errno in (errno.EAGAIN, errno.EWOULDBLOCK, errno.EACCES, errno.EDEADLK):
                return False
            raise refused(self.path, error) from error  # a disk that knows no locks
        if not self._is_current(file):
            file.close()
            return False
        self._file = file
        return True

    def _is_current(self, file: IO[bytes]) -> bool:
        """Check whether nobody removed the lock's file between opening and locking it."""
        try:
            return os.path.samestat(os.fstat(file.fileno()), self.path.lstat())
        except OSError:
            return False

    def release(self) -> None:
        """Give the lock back and remove its file; harmless when it is not held."""
        if self._file is not None:
            try:
                with suppress(OSError):
                    self.path.unlink()
            finally:
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
