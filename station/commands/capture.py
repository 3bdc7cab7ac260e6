"""`station capture`: record one release from a board, then identify it."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from station import exits
from station.commands.options import (
    BAUD,
    COLUMNS,
    NO_VIEWER,
    POSITIVE,
    RELEASE,
    UNITS,
    declared,
    new_session_option,
    option,
)
from station.output import asked_for_json, progress
from station.settings import Settings
from station.text.content import Part

MOST_TAKES = 3
KEPT_BEFORE = click.FloatRange(0.5, 60)

if TYPE_CHECKING:
    from daq.session import Session


HOW = RELEASE | {
    "pre_trigger": (float, option("Seconds kept before the release (1).", type=KEPT_BEFORE, metavar="S")),
    "level": (float, option("Smallest swing of a release, in SI units.", type=POSITIVE, metavar="SIZE")),
    "release": (
        str,
        option(
            "The rig moves the mass there and releases it, as 12mm or -8mm (default: you release it by hand).",
            metavar="LENGTH",
        ),
    ),
}
"""How a release is recorded, for `declared`."""


@declared("capture", HOW)
def command(
    settings: Settings,
    /,
    port: str | None = option(
        "Port of the board, as /dev/ttyACM0, COM3 or socket://HOST:PORT (default: the only board that answers).",
        metavar="URL",
    ),
    folder: Path | None = new_session_option("Folder of the new session (default: ./sessions/release_TIME)."),
    lines: bool = option("The board prints numbers, a line a sample; PORT may be a file that grows."),
    profile: str | None = option(
        "What its lines mean, as kept by `station profile` (implies --lines).", metavar="NAME"
    ),
    source: str | None = option(
        "Instead of a port: audio, audio:DEVICE, or FILE.py:CLASS.", metavar="SOURCE"
    ),
    columns: dict[str, str | int] = COLUMNS,
    units: dict[str, str] = UNITS,
    baud: int | None = BAUD,
    spare: Path | None = option(
        "Where the session goes when its disk fails (default: a terminal asks, else a temporary folder: exit 10).",
        metavar="FOLDER",
    ),
    no_viewer: bool = NO_VIEWER,
    again: bool | None = option(
        "Take a rejected release again without asking, twice at most; or never ask (default: a terminal asks).",
        "--again/--no-again",
        default=None,
    ),
    **given: Any,
) -> int:
    """Record one release, judge the recording, and identify it.

    Hold the mass still until the station is armed, then let it go.
    """
    from daq.failover import is_temporary
    from daq.sources.open_source import LineOptions
    from station.operations.capturing import board_behind, record
    from station.operations.new_session import capture_settings, new_folder

    told = LineOptions(None, columns, units, given["rate"], baud)
    board = board_behind(port, settings, told, lines, profile, source)
    wanted = capture_settings(settings, **given)
    place = folder or new_folder(settings.sessions)
    session, shown_at = record(board(), wanted, place, not no_viewer, spare)
    for number in range(2, MOST_TAKES + 1):
        if not take_again(session, again):
            break
        place = folder.with_name(f"{folder.name}_{number}") if folder else new_folder(settings.sessions)
        session, shown_at = record(board(), wanted, place, not no_viewer, spare)
    finish(session, shown_at, settings)
    return exits.ELSEWHERE if is_temporary(session.folder) else exits.DONE


def take_again(session: "Session", again: bool | None) -> bool:
    """Tell whether a release that was not good is to be taken again: by the option, or by asking at a terminal."""
    verdict = session.verdict
    if verdict is None or verdict.grade.value == "OK" or again is False:
        return False
    sentence = f"{verdict.grade.value}: {verdict.reasons[0]}"
    if again is None:
        if asked_for_json() or not (sys.stdin.isatty() and sys.stderr.isatty()):
            return False
        progress(sentence)
        return click.confirm("Take it again?", default=verdict.grade.value == "REJECT", err=True)
    if verdict.grade.value != "REJECT":
        return False
    progress(f"{sentence}; taken again (kept: {session.folder})")
    return True


def finish(
    session: "Session",
    shown_at: int | None,
    settings: Settings,
    note: tuple[Part, ...] = (),
    **more: Any,
) -> None:
    """Print the verdict, identify, show in the viewer at the port `shown_at`.

    `note` follows what is printed, `more` goes into the JSON object.
    """
    from dataclasses import replace

    from station.operations.identifying import identify_session, refuse_if_nothing
    from station.operations.viewer_tabs import write_view
    from station.text.identification_text import next_command, told
    from station.text.layout import answer
    from station.views import viewer

    verdict = session.verdict
    if verdict is not None:
        progress(f"verdict: {verdict.words}")
        for remark in verdict.remarks:
            progress(remark)
        stopped = session.info.state.value == "aborted" and session.info.reason.startswith("interrupted")
        for advice in ("let the recording run to its end",) if stopped else verdict.advice:
            progress(f"  to take it again: {advice}")
    result, document = identify_session(session, settings)
    file = write_view(session, result, settings)
    if shown_at is not None:
        viewer.show(file, shown_at)
    progress(f"viewer's recording: {file}")
    known = {
        "session": str(session.folder),
        "viewer_recording": str(file),
        "verdict": None if verdict is None else verdict.model_dump(mode="json"),
        "identification": document,
    }
    words = told(session.folder.name, result)
    words = replace(words, brief=(*words.brief, *note))
    answer(known | more, words, next_command(result), session.folder)
    refuse_if_nothing(result)
