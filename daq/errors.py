"""The errors on the way from a port to a sealed session, sorted by who can mend them.

Each message says what happened, what was kept and what to do, in one sentence or two.
"""

from pathlib import Path


class StationError(Exception):
    """An error with a message for the operator; `exit_code` is the program's, `session` the folder that was kept."""

    exit_code = 1

    def __init__(self, message: str, session: Path | None = None) -> None:
        super().__init__(message)
        self.session = session


class OperatorError(StationError):
    """The request cannot be met as it stands."""

    exit_code = 2


class NotASession(OperatorError):
    """The folder is not a session."""


class PortError(StationError):
    """There is no board, or its port cannot be had."""

    exit_code = 3


class PortBusy(PortError):
    """Another program has the port."""


class BoardError(StationError):
    """The board does something that it should not."""

    exit_code = 4


class DataLost(StationError):
    """More samples stayed lost than the settings allow; the session is kept."""

    exit_code = 5


class LinkLost(StationError):
    """The connection ended before the recording did; what was received is kept."""

    exit_code = 6


class StorageError(StationError):
    """The disk refused, or what it holds is not what was written."""

    exit_code = 7


class SessionLocked(StorageError):
    """Another process is writing this session."""

    exit_code = 9


class SessionChanged(StorageError):
    """Another process changed what a change was to be based on; nothing was written."""

    exit_code = 9


class NotWritable(StorageError):
    """Nothing may be written there; what is there can be read."""


class SessionDamaged(StorageError):
    """A checksum does not match."""
