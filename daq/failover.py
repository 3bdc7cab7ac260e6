"""A session written through a failing disk: the same log and session, continued in another folder."""

import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from daq.errors import OperatorError, StorageError
from daq.raw_log import RawLog
from daq.session_folder import Session
from daq.session_info import SessionInfo, State
from daq.storage import require_space

FallbackFolder = Callable[[StorageError], Path | None]
PLACES = 10
PREFIX = "free-decay-session-"


def temporary_folder(error: StorageError) -> Path | None:
    """Return a new folder among the system's temporary files, or None when there is none either."""
    try:
        return Path(tempfile.mkdtemp(prefix=PREFIX))
    except OSError:
        return None


def is_temporary(folder: Path) -> bool:
    """Check whether `temporary_folder` made this folder."""
    return folder.name.startswith(PREFIX) and folder.parent == Path(tempfile.gettempdir())


class SessionWriter:
    """A session that is being written, and where it goes when its disk fails."""

    def __init__(self, session: Session, log: RawLog, fallback: FallbackFolder | None) -> None:
        self._session = session
        self._log = log
        self._fallback = fallback or temporary_folder

    @classmethod
    def begin(
        cls, folder: Path, info: SessionInfo, log: RawLog, fallback: FallbackFolder | None, space: int
    ) -> "SessionWriter":
        """Create the session, in another place when the first refuses and `fallback` offers one."""
        for _ in range(PLACES):
            try:
                require_space(folder, space)
                return cls(Session.create(folder, info, log), log, fallback)
            except StorageError as error:
                place = fallback(error) if fallback is not None else None
                if place is None:
                    raise
                folder = place
        raise StorageError(f"no place was found for the session; the last was {folder}")

    def finish(self, state: State, reason: str, changes: dict[str, Any], **counts: Any) -> Session:
        """Close the log and seal the session, in another place if its own refuses.

        StorageError when no place is left.
        """
        self._log.close()
        failure = self._log.failure
        for _ in range(PLACES):
            try:
                if failure is not None:
                    place = self._fallback(StorageError(f"{failure}; the recording is held in memory"))
                    if place is None:
                        break
                    self._move(place, failure)
                self._session.update(**changes)
                self._session.seal(state, reason, **counts)
                return self._session
            except (StorageError, OperatorError) as error:
                failure = error if isinstance(error, StorageError) else StorageError(str(error))
        self._session.release()
        raise StorageError(f"no place was found for the session: {failure}", self._session.folder)

    def _move(self, place: Path, failure: StorageError) -> None:
        """Write the whole log into a new session at `place`."""
        moved = Session.create(place, self._session.info.model_copy(update={"name": ""}), self._log)
        self._log.close()
        with suppress(StorageError, OperatorError):
            self._session.update(state=State.ABORTED, reason=f"continued in {place}: {failure}")
        self._session.release()
        self._session = moved
        if self._log.failure is not None:
            raise self._log.failure
