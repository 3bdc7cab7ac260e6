"""One release from a board into a session, with the operator watching."""

import contextlib
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import click

from daq.capture import CaptureObserver, CaptureSettings, capture
from daq.errors import StorageError
from daq.failover import is_temporary, temporary_folder
from daq.port import Port
from daq.session import Session
from station.operations.new_session import new_folder
from station.output import progress
from station.text.capture_progress import Watch


def record(
    port: str | Port, settings: CaptureSettings, folder: Path, with_viewer: bool, spare: Path | None = None
) -> tuple[Session, int | None]:
    """Capture one release; return the sealed session and the port of the live viewer, None without one.

    Where the disk fails, the session goes into a new folder under `spare`, or where the operator says, at last into a
    temporary one (`is_temporary`), which is said.
    """
    with live_screen(settings.rate_hz, with_viewer) as (shown_at, live), Watch(live) as watch:
        session = capture(port, settings, folder, watch, another_place(spare))
    if is_temporary(session.folder):
        progress(
            f"the disk refused {folder}: the session lies in {session.folder}, a temporary folder;"
            " move it before this computer is restarted"
        )
    return session, shown_at


def another_place(spare: Path | None) -> Callable[[StorageError], Path | None] | None:
    """Make the function that finds another folder when the disk fails: `spare` once, then the operator at a terminal.

    None without either: a disk that fails before the capture is then refused at once. What no answer finds a place
    for goes among the system's temporary files.
    """
    asks = sys.stdin is not None and sys.stdin.isatty() and sys.stderr.isatty()
    if spare is None and not asks:
        return None
    places = [] if spare is None else [spare]

    def offer(error: StorageError) -> Path | None:
        progress(str(error))
        folder = new_folder(places.pop()) if places else _asked() if asks else None
        if folder is None:
            return temporary_folder(error)
        progress(f"the session goes to {folder}")
        return folder

    return offer


def _asked() -> Path | None:
    """Ask the operator for a folder; None without an answer: the samples in memory must not depend on one."""
    try:
        answer = click.prompt(
            "another folder for the session (Enter: a temporary one)",
            default="",
            show_default=False,
            err=True,
        )
    except click.Abort:
        return None
    return new_folder(Path(answer)) if answer.strip() else None


@contextlib.contextmanager
def live_screen(rate: float, with_viewer: bool) -> Iterator[tuple[int | None, CaptureObserver | None]]:
    """Open a live viewer where one is wanted and a window can be opened; give its port and its observer."""
    if with_viewer:
        from station.views.viewer import has_screen

        if has_screen():
            from station.views.live import live_viewer

            with live_viewer(rate) as live:
                yield live
                return
        progress("no screen here: no live view")
    yield None, None
