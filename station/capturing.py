"""One release from a board into a session, with the operator watching."""

import contextlib
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from daq.capture import CaptureObserver, CaptureSettings, capture
from daq.session import Session
from station.identification import Identification
from station.output import progress
from station.watching import Several, Watch


@dataclass(frozen=True)
class Screen:
    """The live viewer, when there is one: `url` is where it listens."""

    url: str | None
    observers: tuple[CaptureObserver, ...]


def new_folder(sessions: Path, prefix: str = "release") -> Path:
    """Return a folder for a new session, named by the time, that does not exist yet."""
    stamp = time.strftime("%Y%m%d_%H%M%S")
    folder, number = sessions / f"{prefix}_{stamp}", 1
    while folder.exists():
        number += 1
        folder = sessions / f"{prefix}_{stamp}_{number}"
    return folder


def record(
    port: str, settings: CaptureSettings, folder: Path, with_viewer: bool
) -> tuple[Session, str | None]:
    """Capture one release; return the sealed session and the URL of the live viewer, None without one."""
    with live_screen(settings.rate_hz, with_viewer) as screen, Watch() as watch:
        session = capture(port, settings, folder, Several((watch, *screen.observers)))
    return session, screen.url


@contextlib.contextmanager
def live_screen(rate: float, with_viewer: bool) -> Iterator[Screen]:
    """Open a live viewer where one is wanted and a window can be opened."""
    if with_viewer:
        from station.views.viewer import has_screen

        if has_screen():
            from station.views.live import LiveViewer

            with LiveViewer(rate) as live:
                yield Screen(live.url, (live.view,))
                return
        progress("no screen here: no live view")
    yield Screen(None, ())


def show_result(url: str | None, session: Session, result: Identification) -> Path:
    """Keep the viewer's recording in the session, and show it in the live viewer when there is one."""
    from station.identifying import write_view

    file = write_view(session, result)
    if url is not None:
        from station.views import show

        show.send(url, session.folder.name, result)
    return file
