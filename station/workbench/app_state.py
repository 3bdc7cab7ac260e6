"""What all tabs share: the workers, the sessions on offer, and those that are open."""

from dataclasses import dataclass
from pathlib import Path

from station.settings import Settings
from station.workbench.capture_run import CaptureRun
from station.workbench.session_list import SessionList
from station.workbench.session_state import SessionStates
from station.workbench.worker import WorkerPool


@dataclass
class AppState:
    """Settings, workers, the sessions on offer, those that are open, and the one capture at a time.

    `temporary` is a folder that goes when the server ends.
    """

    settings: Settings
    workers: WorkerPool
    session_list: SessionList
    sessions: SessionStates
    temporary: Path
    capturing: CaptureRun | None = None
