"""The folder of a campaign: one document for each session, written as soon as it is done."""

import re
from pathlib import Path

from daq.errors import StationError
from daq.storage import read_regular, refused, write_whole
from station.results.campaign_document import NAME, CampaignDocument, SessionResult
from station.results.documents import LARGEST
from station.text import campaign_table as table

SESSIONS = "sessions"
LONGEST_NAME = 80


class Kept:
    """The results that a campaign keeps, by the key of the session's content and the settings."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def make(self) -> None:
        """Make the folder; StorageError when the disk refuses."""
        try:
            (self.folder / SESSIONS).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise refused(self.folder, error) from error

    def file(self, name: str, key: str) -> Path:
        """Return the file in which the result of a session is kept."""
        plain = re.sub(r"[^\w.-]+", "_", name)[:LONGEST_NAME]
        return self.folder / SESSIONS / f"{plain}-{key[:16]}.json"

    def read(self, name: str, key: str) -> SessionResult | None:
        """Return the result of a session, None where there is none that can be read: it is made again."""
        try:
            found = SessionResult.model_validate_json(read_regular(self.file(name, key), LARGEST))
        except (StationError, ValueError):
            return None
        return found if found.key == key else None

    def write(self, name: str, key: str, result: str) -> None:
        """Keep the result of a session, whole or not at all."""
        write_whole(self.file(name, key), result.encode())

    def write_table(self, document: CampaignDocument) -> None:
        """Keep what the sessions say together, also as tables."""
        files = {NAME: document.model_dump_json(indent=1) + "\n"}
        files |= {table.SESSIONS: table.sessions_csv(document), table.TRENDS: table.trends_csv(document)}
        for name, content in files.items():
            write_whole(self.folder / name, content.encode())
