"""`station guide`: a test that says what to release next, until it is sure what is missing."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from station import exits
from station.commands.options import JSON, RELEASE, declared, new_session_option, option
from station.output import print_json, progress, screen
from station.settings import Settings

if TYPE_CHECKING:
    from identify.diagnosis.next_release import Limits
    from station.operations.guiding import GuidedTest
    from station.results.guide_document import GuideDocument


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
    as_json: bool = JSON,
    **given: Any,
) -> int:
    """Say what to release, record it, judge it, and say what to release next.

    It ends when a name is confirmed by two releases, when nothing can hide any
    more within the limits, or when no release would tell more. All releases
    form one campaign with one report.
    """
    from daq.ports import choose_port
    from station.operations.guiding import GuidedTest
    from station.operations.new_session import new_folder, wanted_capture

    chosen = limits_of(limits if limits is not None else _asked(), unattended)
    wanted = wanted_capture(settings, given)
    named = choose_port(port or settings.capture.port)
    place = folder or new_folder(settings.sessions, "guide")
    document = show_guided(GuidedTest(named, wanted, chosen, place, settings, unattended), as_json)
    if as_json:
        print_json(document.plain())
    return exits.DONE


def show_guided(test: "GuidedTest", as_json: bool) -> "GuideDocument":
    """Run a guided test on the screen (on stderr where JSON is wanted); return its document."""
    from station.operations.guiding import guide
    from station.report.guided import finish
    from station.safe_text import SafeConsole
    from station.text.guide_text import GuideScreen, show_guide

    console = SafeConsole(stderr=True, highlight=False) if as_json else screen()
    document = guide(test, GuideScreen(console, alone=test.alone))
    progress("writing the report")
    document = finish(test, document)
    show_guide(console, document)
    return document


def limits_of(text: str, unattended: bool = False) -> "Limits":
    """Return the limits of a rig from "2mm,25mm"; UsageProblem for what is none."""
    from identify.diagnosis.next_release import Limits
    from station.operations.new_session import metres

    lengths = [length for word in text.split(",") if (length := metres(word)) is not None]
    if len(lengths) <= text.count(","):
        raise exits.UsageProblem(f"--limits {text}: write two lengths with their units, as 2mm,25mm")
    if len(lengths) != 2 or not 0.0 < lengths[0] < lengths[1]:
        raise exits.UsageProblem(
            f"--limits {text}: write the smallest and the largest safe amplitude, both above 0, as 2mm,25mm"
        )
    ways = ("longer", "rest") if unattended else ("push", "longer", "rest")
    return Limits(lengths[0], lengths[1], ways=ways)


def _asked() -> str:
    """Ask for the limits at a terminal; UsageProblem where there is none."""
    if not (sys.stdin is not None and sys.stdin.isatty() and sys.stderr.isatty()):
        raise exits.UsageProblem(
            "give the safe amplitudes as --limits 2mm,25mm; without a terminal nobody can be asked"
        )
    answer: str = click.prompt("Between which amplitudes may the mass be released, as 2mm,25mm", err=True)
    return answer
