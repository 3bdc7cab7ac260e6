"""The typical noise of a board: its noise at rest in the sessions beside this one."""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from statistics import median

from daq.errors import StationError
from daq.session_info import SessionInfo
from daq.session_reading import INFO, read_info

FEWEST_SESSIONS = 3
_MOST_SESSIONS = 50


def typical_noise(folder: Path, info: SessionInfo) -> dict[str, float]:
    """Return the median noise of each channel (channel's unit) over the latest sessions beside `folder`.

    Only captures of the same board count, and only channels that three of them know; empty where there are
    fewer. Folders that are no session are passed over.
    """
    if info.board is None or not info.board.unique_id:
        return {}
    seen: dict[str, list[float]] = {}
    for other in _neighbours(folder):
        if other.board is None or other.board.unique_id != info.board.unique_id:
            continue
        for channel, noise in other.noise.items():
            if noise > 0.0:
                seen.setdefault(channel, []).append(noise)
    return {channel: median(values) for channel, values in seen.items() if len(values) >= FEWEST_SESSIONS}


def _neighbours(folder: Path) -> Iterator[SessionInfo]:
    """Yield the metadata of the newest sessions in the same folder."""
    try:
        files = [f for f in folder.absolute().parent.glob(f"*/{INFO}") if f.parent.name != folder.name]
        files = sorted(files, key=lambda f: f.stat().st_mtime, reverse=True)[:_MOST_SESSIONS]
    except OSError:  # the folder was deleted
        return
    for file in files:
        with suppress(StationError):  # not a session, or one being written
            yield read_info(file.parent)
