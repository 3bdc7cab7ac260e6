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


class SettingsError(OperatorError):
    """A setting is out of its range or contradicts another."""


class SessionExists(OperatorError):
    """The folder holds something already; nothing was overwritten."""


class NotASession(OperatorError):
    """The folder is not a session."""


class NoRelease(OperatorError):
    """The station was armed (or waited for rest) and nothing came within the time set."""


class CannotHold(OperatorError):
    """The board was to hold and release the mass, and has no holder."""


class PortError(StationError):
    """There is no board, or its port cannot be had."""

    exit_code = 3


class NoBoard(PortError):
    """Nothing is there, or nothing that answers as a board."""


class SeveralBoards(PortError):
    """More than one board answers and none was named."""


class PortNotAllowed(PortError):
    """What was named as a port is none; nothing was opened."""


class PortBusy(PortError):
    """Another program has the port."""


class PortForbidden(PortError):
    """The port is there but this user may not open it."""


class BoardError(StationError):
    """The board does something that it should not."""

    exit_code = 4


class VersionRefused(BoardError):
    """The board speaks another major version of the protocol."""


class BoardRefused(BoardError):
    """The board answered NACK."""


class LetGo(BoardError):
    """The rig let go of the mass, slowly, before it was told to release it."""


class ProtocolError(BoardError):
    """The board's messages contradict the protocol or each other."""


class DataLost(StationError):
    """More samples stayed lost than the settings allow; the session is kept."""

    exit_code = 5


class LinkLost(StationError):
    """The connection ended before the recording did; what was received is kept."""

    exit_code = 6


class Disconnected(LinkLost):
    """The port went away."""


class Stalled(LinkLost):
    """The board is connected but silent."""


class Rebooted(LinkLost):
    """The board restarted in mid-capture: its sample index began again."""


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
