"""The room: what all tabs share. Workers, shelf and desks."""

from dataclasses import dataclass

from station.settings import Settings
from station.workbench.desk import Desks
from station.workbench.shelf import Shelf
from station.workbench.worker import Crew


@dataclass(frozen=True)
class Room:
    """Settings, workers, the sessions on offer, and the desks of those that are open."""

    settings: Settings
    crew: Crew
    shelf: Shelf
    desks: Desks
