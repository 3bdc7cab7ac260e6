"""The sessions that the page offers, newest first, each with its thumbnail."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from urllib.parse import quote

import numpy as np

from daq.errors import StationError
from daq.manifest import NAME as MANIFEST
from daq.recording import Array
from daq.session import Session, SessionSummary, State, list_sessions
from daq.session_reading import RAW
from identify.free_decay import CHANNELS
from station.results.guide_document import NAME
from station.story.preparation import motion_channels
from station.text.numbers import scale_as_recorded, typeset
from station.workbench.view_models import Numbers

MOST = 200
POINTS = 60
"""Parts of a decay whose outline is drawn."""


def address_of(key: str) -> str:
    """Write the address of a session's page."""
    return f"/?session={quote(key, safe='')}"


@dataclass(frozen=True)
class Entry:
    """One session: its key in addresses, its folder, and what is said of it; as its thumbnail, where that was asked for, the
    largest amplitude in words, and the decay as points for a sparkline (-1 to 1)."""

    key: str
    folder: Path
    date: str
    verdict: str
    problem: str = ""
    notes: str = ""
    amplitude: str = ""
    line: Numbers = field(default_factory=list)

    @property
    def address(self) -> str:
        """Where its page is."""
        return address_of(self.key)

    @property
    def words(self) -> str:
        """What a filter looks in."""
        return f"{self.key} {self.date} {self.verdict} {self.notes}".lower()


class SessionList:
    """The sessions of a folder, those of the guided tests in it, and those named on the command line."""

    def __init__(self, sessions: Path, named: tuple[Path, ...]) -> None:
        self.sessions = sessions
        self.problem = ""
        self._named = tuple(folder.resolve() for folder in named)

    def entries(self, thumbnails: bool = False) -> tuple[Entry, ...]:
        """List the sessions, those of the command line first, then the newest."""
        self.problem = ""
        found: dict[str, Entry] = {}
        try:
            for summary in self._summaries():
                entry = _entry(summary, thumbnails)
                found.setdefault(entry.key, entry)
        except StationError as error:
            self.problem = str(error)
        return tuple(found.values())[:MOST]

    def _summaries(self) -> Iterator[SessionSummary]:
        for parent in dict.fromkeys(folder.parent for folder in self._named):
            yield from (s for s in list_sessions(parent) if s.folder.resolve() in self._named)
        if self.sessions.is_dir():
            guided = (file.parent for file in self.sessions.glob(f"*/{NAME}"))
            found = (summary for parent in (self.sessions, *guided) for summary in list_sessions(parent))
            yield from sorted(
                found, key=lambda s: s.info.created.timestamp() if s.info else 0.0, reverse=True
            )

    def folder_of(self, key: str) -> Path | None:
        """Find the folder of a session by its key; None when there is none (nothing outside can be named)."""
        return next((entry.folder for entry in self.entries() if entry.key == key), None)

    def result_of(self, key: str, name: str) -> Path | None:
        """Find a file among the results of a session; None when there is none."""
        folder = self.folder_of(key)
        file = None if folder is None else folder / "results" / name
        return file if file is not None and file.is_file() and not file.is_symlink() else None


def _entry(summary: SessionSummary, with_thumbnail: bool) -> Entry:
    folder, info = summary.folder.resolve(), summary.info
    if info is None:
        return Entry(folder.name, folder, "", "damaged", summary.problem)
    date = info.created.astimezone().strftime("%Y-%m-%d %H:%M")
    word = info.verdict if info.verdict and info.state is not State.ABORTED else info.state.value
    if info.state is not State.RECORDING and not (folder / MANIFEST).exists():
        word = "no manifest"
    notes = " ".join(filter(None, (info.specimen, info.operator, info.remarks)))
    raw = folder / RAW
    drawn = with_thumbnail and info.state is not State.RECORDING and raw.is_file()
    amplitude, line, problem = thumbnail_of(folder, raw.stat().st_mtime_ns) if drawn else ("", [], "")
    return Entry(folder.name, folder, date, word, problem, notes, amplitude, line)


@lru_cache(maxsize=1000)
def thumbnail_of(folder: Path, stamp: int) -> tuple[str, Numbers, str]:
    """Find the largest amplitude, in words, and the outline of the decay; or say why there is none.

    `stamp` changes when the recording does: a thumbnail is made once for each.
    """
    try:
        recording = Session.open(folder).recording()
    except StationError as error:
        return "", [], str(error)
    if not recording.channels or recording.samples.shape[1] < 2:
        return "", [], "no samples"
    motions = motion_channels(recording)
    channel = next((motions[name] for name in CHANNELS if name in motions), recording.channels[0])
    row = recording.channels.index(channel)
    values = np.where(recording.valid, recording.samples[row], np.nan)
    if not np.isfinite(values).any():
        return "", [], "no samples"
    factor, unit = scale_as_recorded(channel.quantity, channel.unit)
    largest, line = outline(values)
    return f"{largest * factor:.3g} {typeset(unit)}", line, ""


def outline(values: Array) -> tuple[float, Numbers]:
    """Measure how far values go from where they end, and their outline, up and down, as shares of that; NaN leave holes."""
    known = values[np.isfinite(values)]
    if not len(known):
        return 0.0, []
    values = values - np.median(known[-len(known) // 4 :])  # not of all: before the release it was held aside
    largest = float(np.nanmax(np.abs(values)))
    line: list[float | None] = []
    for part in np.array_split(values, POINTS):
        finite = part[np.isfinite(part)]
        if len(finite):
            line += [round(float(edge) / (largest or 1.0), 2) for edge in (finite.max(), finite.min())]
        else:
            line += [None, None]
    return largest, line
