"""One release into a session, with the operator watching; from a board, one that prints lines, or another source."""

import contextlib
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import click

from daq.capture import CaptureObserver, CaptureSettings, capture
from daq.errors import StorageError
from daq.failover import is_temporary, temporary_folder
from daq.port import Port
from daq.ports import choose_port
from daq.session import Session
from daq.sources import SourceBoard
from daq.sources.line_format import load_profile
from daq.sources.open_source import LineOptions, open_lines, open_source
from station.exits import UsageProblem
from station.operations.new_session import new_folder
from station.output import progress
from station.settings import Settings
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


def profiles_of(settings: Settings) -> Path:
    """Return the folder of the profiles, beside the sessions."""
    return settings.sessions.parent / "profiles"


def board_behind(
    port: str | None,
    settings: Settings,
    told: LineOptions,
    lines: bool,
    profile: str | None,
    source: str | None,
) -> Callable[[], str | Port]:
    """Make the function that opens the board for each release: its port, or a source behind an adapter.

    The board speaks the protocol unless it prints `lines`, has a `profile`, or is another `source`; `told` is what the
    operator said of it. Raises UsageProblem where that is a contradiction, OperatorError for a profile that is not there.
    """
    named, by_lines = port or settings.capture.port, lines or profile is not None
    if by_lines and source is not None:
        raise UsageProblem("--lines and --source are two kinds of board; give one of them")
    if not by_lines and source is None:
        options = {"--column": told.columns, "--unit": told.units, "--baud": told.baud}
        if given := [option for option, value in options.items() if value]:
            raise UsageProblem(
                f"{given[0]} belongs to --lines or --source; a board of the protocol says it itself"
            )
        chosen = choose_port(named)
        return lambda: chosen
    if by_lines and not named:
        raise UsageProblem(
            "name the port whose lines are to be read, as --port /dev/ttyUSB0 (see `station ports`)"
        )
    if profile is not None:
        told = replace(told, form=load_profile(profile, profiles_of(settings)))

    def opened() -> Port:
        if source is not None:
            board = SourceBoard(open_source(source, told))
        else:
            progress(f"listening to {named} for some seconds")
            board = SourceBoard(open_lines(named or "", told))
        found = board.description
        channels = ", ".join(f"{c.quantity} '{c.name}' in {c.unit}" for c in found.channels)
        for line in (f"{found.name}: {channels}", *found.remarks):
            progress(line)
        return board

    return opened
