"""The raw log: every byte as it came and went, written before it is decoded.

A file is `MAGIC`, then records. A record is a head of 24 bytes (marker, kind, payload length, host time,
CRC-32 of the payload, CRC-32 of the head before it) and the payload. Because a record is handed to the
operating system in one `write`, a killed process leaves whole records and at most one cut one; a flipped
bit costs the record it is in and no other.
"""

import json
import os
import threading
import time
from contextlib import suppress
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from struct import Struct
from typing import Any
from zlib import crc32

from daq.errors import SessionDamaged, StorageError
from daq.storage import open_new, read_regular, refused, sync_directory, write_all

MAGIC = b"free-decay raw 1\n"
MARKER = b"\xf5\xdb"
SYNC_EVERY_S = 0.25
MAX_PAYLOAD = 1 << 20
MAX_LOG = 1 << 31

_HEAD = Struct("<2sBxIdI")
_CHECK = Struct("<I")
HEAD_SIZE = _HEAD.size + _CHECK.size


class Kind(IntEnum):
    """What a record holds."""

    RECEIVED = 1
    SENT = 2
    NOTE = 3
    SOURCE = 4  # what a source that is no board of the protocol gave, before it was made DATA


_KINDS = frozenset(Kind)


@dataclass(frozen=True)
class Record:
    """One record: `time` is the host's, seconds since the epoch on a clock that never steps."""

    kind: Kind
    time: float
    payload: bytes

    def note(self) -> dict[str, Any]:
        """Parse a NOTE of the station; empty when it is no JSON object."""
        try:
            value = json.loads(self.payload)
        except (ValueError, RecursionError):
            return {}
        return value if isinstance(value, dict) else {}


@dataclass(frozen=True)
class RawRecords:
    """What a log holds: whole records in order, `damaged` pieces skipped, `cut` bytes after the last one."""

    records: tuple[Record, ...]
    damaged: int
    cut: int


_EPOCH = time.time() - time.monotonic()


def host_time() -> float:
    """Seconds since the epoch, by a clock that is never set while the program runs."""
    return _EPOCH + time.monotonic()


def pack(record: Record) -> bytes:
    """Return the bytes of one record."""
    head = _HEAD.pack(MARKER, record.kind, len(record.payload), record.time, crc32(record.payload))
    return head + _CHECK.pack(crc32(head)) + record.payload


def unpack(data: bytes) -> RawRecords:
    """Return the whole records of a log's bytes, past anything that is damaged.

    SessionDamaged when it does not begin as a raw log. Takes time in proportion to the length.
    """
    if not data.startswith(MAGIC):
        raise SessionDamaged("the raw log does not begin as one; it was overwritten or is another file")
    records: list[Record] = []
    damaged, at, end = 0, len(MAGIC), len(data)
    while at + HEAD_SIZE <= end:
        marker, kind, length, when, check = _HEAD.unpack_from(data, at)
        (head_check,) = _CHECK.unpack_from(data, at + _HEAD.size)
        if marker != MARKER or head_check != crc32(data[at : at + _HEAD.size]):
            damaged += 1
            at = _next_head(data, at + 1)
            continue
        start = at + HEAD_SIZE
        if start + length > end:
            break
        at = start + length
        payload = data[start:at]
        if crc32(payload) == check and kind in _KINDS:
            records.append(Record(Kind(kind), when, payload))
        else:
            damaged += 1
    return RawRecords(tuple(records), damaged, end - at)


def _next_head(data: bytes, at: int) -> int:
    """Find the next sound head, or the end."""
    while 0 <= (at := data.find(MARKER, at)) <= len(data) - HEAD_SIZE:
        (check,) = _CHECK.unpack_from(data, at + _HEAD.size)
        if check == crc32(data[at : at + _HEAD.size]):
            return at
        at += 1
    return len(data)


def read(path: Path) -> RawRecords:
    """Read the log at `path`; StorageError when it cannot be read."""
    return unpack(read_regular(path, MAX_LOG))


class RawLog:
    """Records in memory and, from `store` on, in a file too. Any thread may append.

    When the disk fails the log goes on in memory: `failure` says why, nothing is raised, and
    `store` in another place writes everything from the first record on. The memory it takes is the
    `size` of the file in bytes (about 1 kB/s for two channels at 256 Hz).
    """

    def __init__(self) -> None:
        self.failure: StorageError | None = None
        self.path: Path | None = None
        self.size = len(MAGIC)
        self._records: list[bytes] = [MAGIC]
        self._fd: int | None = None
        self._lock = threading.Lock()
        self._synced = 0.0
        self._dirty = False

    def append(self, kind: Kind, payload: bytes, when: float | None = None) -> float:
        """Write one record and return its host time."""
        when = host_time() if when is None else when
        for at in range(0, max(len(payload), 1), MAX_PAYLOAD):
            record = pack(Record(kind, when, payload[at : at + MAX_PAYLOAD]))
            with self._lock:
                self._records.append(record)
                self.size += len(record)
                self._write(record)
        return when

    def note(self, **values: object) -> None:
        """Write down something the station did, as JSON, between the bytes."""
        self.append(Kind.NOTE, json.dumps(values).encode())

    def store(self, path: Path) -> None:
        """From now on keep the log in this new file too, from its first record on.

        StorageError when the file is there already or the disk refuses; the log in memory is untouched.
        """
        fd = open_new(path)
        with self._lock:
            self._close()
            self._fd, self.path, self.failure = fd, path, None
            self._records = [b"".join(self._records)]
            self._write(self._records[0])
        self.sync()
        sync_directory(path.parent)
        if self.failure is not None:
            raise self.failure

    def sync_if_due(self) -> None:
        """Call often: forces the file to the disk about every 250 ms."""
        if self._dirty and time.monotonic() - self._synced > SYNC_EVERY_S:
            self.sync()

    def sync(self) -> None:
        """Force the file to the disk now, and notice when it has been deleted."""
        fd, self._dirty, self._synced = self._fd, False, time.monotonic()
        if fd is None:
            return
        try:
            getattr(os, "fdatasync", os.fsync)(fd)
            if os.fstat(fd).st_nlink == 0 or self.path is None or not self.path.exists():
                raise OSError("the file was deleted or its folder vanished")
        except OSError as error:
            with self._lock:
                self._fail(error)

    def close(self) -> None:
        """Sync and close the file; the records stay in memory."""
        self.sync()
        with self._lock:
            self._close()

    @property
    def data(self) -> bytes:
        """All bytes of the log."""
        with self._lock:
            self._records = [b"".join(self._records)]
            return self._records[0]

    def _write(self, data: bytes) -> None:
        if self._fd is None:
            return
        try:
            write_all(self._fd, data)
            self._dirty = True
        except OSError as error:
            self._fail(error)

    def _fail(self, error: OSError) -> None:
        where = self.path
        self._close()
        self.failure = refused(where or Path(), error)

    def _close(self) -> None:
        if self._fd is not None:
            fd, self._fd = self._fd, None
            with suppress(OSError):
                os.close(fd)
