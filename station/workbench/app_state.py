"""The room: what all tabs share. Workers, shelf and desks."""

from dataclasses import dataclass
from pathlib import Path

from station.settings import Settings
from station.workbench.capture_run import CaptureRun
from station.workbench.session_list import Shelf
from station.workbench.session_state import Desks
from station.workbench.worker import WorkerPool


@dataclass
class Room:
    """Settings, workers, the sessions on offer, the desks of those that are open, and the one capture at a time.

    `aside` is a folder that goes when the server ends.
    """

    settings: Settings
    crew: WorkerPool
    shelf: Shelf
    desks: Desks
    aside: Path
    capturing: CaptureRun | None = None
