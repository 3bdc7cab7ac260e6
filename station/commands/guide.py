"""`station guide`: say what to release next, until it is clear what is missing."""

import sys
from pathlib import Path
from typing import Any

import click

from station import exits
from station.commands.options import RELEASE, declared, new_session_option, option
from station.output import asked_for_json, print_json
from station.settings import Settings


@declared("guide", RELEASE)
def command(
    settings: Settings,
    /,
    port: str | None = option(
        "Port of the board, as for `station capture` (default: the only board that answers).", metavar="URL"
    ),
    limits: str | None = option(
        "Amplitudes that are safe, as 2mm,25mm (default: a terminal asks).", metavar="LOW,HIGH"
    ),
    unattended: bool = option("The rig holds and releases the mass itself."),
    folder: Path | None = new_session_option("Folder of its sessions (default: ./sessions/guide_TIME)."),
    **given: Any,
) -> int:
    """Say what to release, record it, judge it, and say what to release next.

    It ends when an effect is confirmed by two releases, when no effect can
    still hide within the limits, or when no further release would help. All
    releases form one campaign with one report.
    """
    from daq.ports import choose_port
    from station.operations.guiding import GuidedTest, limits_of
    from station.operations.new_session import capture_settings, new_folder

    chosen = limits_of(limits if limits is not None else _asked(), unattended)
    wanted = capture_settings(settings, **given)
    named = choose_port(port or settings.capture.port)
    place = folder or new_folder(settings.sessions, "guide")
    from station.report.write import show_guided

    document = show_guided(GuidedTest(named, wanted, chosen, place, settings, unattended))
    if asked_for_json():
        print_json(document.plain())
    return exits.DONE


def _asked() -> str:
    """Ask for the limits at a terminal; UsageProblem where there is none."""
    if not (sys.stdin is not None and sys.stdin.isatty() and sys.stderr.isatty()):
        raise exits.UsageProblem(
            "give the safe amplitudes as --limits 2mm,25mm; without a terminal nobody can be asked"
        )
    answer: str = click.prompt("Between which amplitudes may the mass be released, as 2mm,25mm", err=True)
    return answer
