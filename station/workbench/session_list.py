"""The sessions that the page offers, newest first, each with its thumbnail."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from daq.errors import StationError
from daq.session import SessionSummary, State, list_sessions
from station.workbench import view_models
from station.workbench.worker import Cancelled, Failed, Job, WorkerPool

MOST = 200


@dataclass(frozen=True)
class Entry:
    """One session: its key in addresses, its folder, and what is said of it; `thumbnail` None while it is being made."""

    key: str
    folder: Path
    date: str
    verdict: str
    problem: str
    thumbnail: view_models.Thumbnail | None
    notes: str = ""

    @property
    def words(self) -> str:
        """What a filter looks in."""
        return f"{self.key} {self.date} {self.verdict} {self.notes}".lower()


class SessionList:
    """The sessions of a folder and those named on the command line; thumbnails are made by workers and remembered."""

    def __init__(self, sessions: Path, named: tuple[Path, ...], workers: WorkerPool) -> None:
        self.sessions = sessions
        self.problem = ""
        self._named = tuple(folder.resolve() for folder in named)
        self._workers = workers
        self._thumbnails: dict[tuple[Path, int], view_models.Thumbnail] = {}
        self._making = False

    def entries(self) -> tuple[Entry, ...]:
        """Return the sessions, those of the command line first, then the newest."""
        self.problem = ""
        found: dict[str, Entry] = {}
        try:
            for summary in self._summaries():
                entry = self._entry(summary)
                found.setdefault(entry.key, entry)
        except StationError as error:
            self.problem = str(error)
        return tuple(found.values())[:MOST]

    def _summaries(self) -> Iterator[SessionSummary]:
        for parent in dict.fromkeys(folder.parent for folder in self._named):
            yield from (s for s in list_sessions(parent) if s.folder.resolve() in self._named)
        if self.sessions.is_dir():
            yield from reversed(list_sessions(self.sessions))

    def folder_of(self, key: str) -> Path | None:
        """Return the folder of a session by its key; None when there is none (nothing outside can be named)."""
        return next((entry.folder for entry in self.entries() if entry.key == key), None)

    def _entry(self, summary: SessionSummary) -> Entry:
        folder, info = summary.folder.resolve(), summary.info
        if info is None:
            return Entry(folder.name, folder, "", "damaged", summary.problem, None)
        date = info.created.astimezone().strftime("%Y-%m-%d %H:%M")
        word = info.verdict if info.verdict and info.state is not State.ABORTED else info.state.value
        notes = " ".join(filter(None, (info.specimen, info.operator, info.remarks)))
        return Entry(folder.name, folder, date, word, "", self._thumbnails.get(_stamp(folder)), notes)

    async def make_thumbnails(self) -> bool:
        """Make the thumbnails that are missing, one at a time; True where one was made."""
        if self._making:
            return False
        self._making = True
        made = False
        try:
            for entry in self.entries():
                if entry.thumbnail is None and not entry.problem and entry.verdict != State.RECORDING.value:
                    thumbnail = await self._thumbnail(entry.folder)
                    self._thumbnails[_stamp(entry.folder)] = thumbnail
                    made = True
        finally:
            self._making = False
        return made

    async def _thumbnail(self, folder: Path) -> view_models.Thumbnail:
        try:
            found: view_models.Thumbnail = await self._workers.do(Job(), "thumbnails", "thumbnail", folder)
        except Cancelled:
            return view_models.Thumbnail("", [], "")
        except Failed as failure:
            return view_models.Thumbnail("", [], str(failure))
        return found


def _stamp(folder: Path) -> tuple[Path, int]:
    try:
        return folder, (folder / "raw.log").stat().st_mtime_ns
    except OSError:
        return folder, 0
