"""A disk that fails at a chosen one of the calls by which the storage reaches it, as SQLite's tests do.

`fault` says how: an error number or a MemoryError is raised once; "full" refuses from then on whatever would take
room; "killed" ends the process there, so that nothing after it reaches the disk. A write that fails has written half.
"""

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from unittest import mock

CALLS = ("open", "write", "fsync", "fdatasync", "replace", "mkdir", "unlink", "rmdir")
TAKE_ROOM = ("open", "write", "fsync", "fdatasync", "mkdir")
FAULTS = ("EIO", "memory", "full", "killed")


class Killed(BaseException):
    """The process is dead."""


class FailingDisk:
    """Counts the calls, and fails at number `at` (from 1); at none where it is 0."""

    def __init__(self, at: int, fault: str) -> None:
        self.calls, self.at, self.fault = 0, at, fault
        self._real = {name: getattr(os, name) for name in CALLS if hasattr(os, name)}

    @property
    def failed(self) -> bool:
        """Whether the call at which it fails was reached."""
        return 0 < self.at <= self.calls

    @contextmanager
    def used(self) -> Iterator[None]:
        """Let every call of this process go through the disk."""
        with mock.patch.multiple(os, **{name: self._through(name) for name in self._real}):
            yield

    def _through(self, name: str):
        def call(*arguments, **named):
            self.calls += 1
            late = self.failed and self.calls > self.at
            if self.calls == self.at or (late and self.fault == "killed"):
                self._fail(name, arguments, half=not late)
            elif late and self.fault == "full" and name in TAKE_ROOM and not self._reads(name, arguments):
                self._fail(name, arguments, half=False)
            return self._real[name](*arguments, **named)

        return call

    @staticmethod
    def _reads(name: str, arguments) -> bool:
        return name == "open" and not arguments[1] & os.O_CREAT

    def _fail(self, name: str, arguments, half: bool) -> None:
        if half and name == "write":
            fd, data = arguments
            self._real["write"](fd, data[: len(data) // 2])
        if self.fault == "killed":
            raise Killed
        if self.fault == "memory":
            raise MemoryError
        number = errno.EIO if self.fault == "EIO" else errno.ENOSPC
        raise OSError(number, os.strerror(number))
