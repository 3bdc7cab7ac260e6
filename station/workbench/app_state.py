"""The state that all tabs share: the workers, the list of sessions, and the open ones."""

from dataclasses import dataclass, field
from pathlib import Path

from station.operations.workers import WorkerPool
from station.settings import Settings
from station.workbench.capture_run import CaptureRun
from station.workbench.session_list import SessionList
from station.workbench.session_state import SessionState


@dataclass
class AppState:
    """Settings, workers, the sessions on offer, those that are open by their folder, and the one capture at a time.

    `temporary` is a folder that goes when the server ends.
    """

    settings: Settings
    workers: WorkerPool
    session_list: SessionList
    temporary: Path
    sessions: dict[Path, SessionState] = field(default_factory=dict)
    capturing: CaptureRun | None = None

    def session(self, folder: Path) -> SessionState:
        """Open the session in a folder, unless a tab has opened it."""
        return self.sessions.setdefault(folder, SessionState(folder, self.workers))

    def moved(self, folder: Path, place: Path) -> None:
        """Forget a session as it was before it was moved; those that are looked at together with it follow it."""
        self.sessions.pop(folder, None)
        for session in self.sessions.values():
            session.follow(folder, place)
