"""`station doctor`: is everything ready for a capture, and if not, what to do."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from station import exits
from station.commands.options import pass_settings
from station.output import json_option, print_json, screen
from station.settings import Settings

if TYPE_CHECKING:
    from station.operations.doctor import Finding


@click.command("doctor")
@click.option(
    "--port", metavar="URL", help="Port of the board (default: the settings', or each that answers)."
)
@click.option(
    "--seconds",
    type=click.FloatRange(min=1, max=60),
    default=2.0,
    show_default=True,
    help="How long to sample; swing the mass meanwhile to have the wiring checked.",
)
@json_option
@pass_settings
def command(settings: Settings, port: str | None, seconds: float, as_json: bool) -> int:
    """Check the computer, the port and the board: PASS, WARN or FAIL, and the remedy.

    Ends with 0 unless a check FAILs, with 3 then.
    """

    findings = list(
        _examine(port or settings.capture.port, settings.sessions, settings.capture.rate, seconds)
    )
    failed = any(finding.grade == "FAIL" for finding in findings)
    if as_json:
        entries = [
            {"grade": f.grade.value, "check": f.check, "found": f.found, "remedy": f.remedy} for f in findings
        ]
        print_json({"ok": not failed, "findings": entries})
    else:
        _print(findings)
        screen().print(_next(findings, port, failed=failed), markup=False, soft_wrap=True)
    return exits.NO_BOARD if failed else exits.DONE


def _next(findings: list["Finding"], port: str | None, *, failed: bool) -> str:
    """Return the command that comes next: a capture where a board answered, the same check once a fault is mended."""
    from station.text.next_step import next_line

    at = () if port is None else ("--port", port)
    if failed:
        return f"{next_line('doctor', *at)} (once what failed is mended)"
    if any(finding.check == "handshake" for finding in findings):
        return next_line("capture", *at)
    return f"{next_line('demo')} (no board is needed for it)"


def _examine(port: str | None, sessions: Path, rate: float, seconds: float) -> Iterator["Finding"]:
    from station.operations import doctor

    yield from doctor.versions()
    yield from doctor.disk(sessions)
    if port:
        yield from _port(port, rate, seconds)
        return
    from daq.ports import list_ports

    found = list_ports()
    if not found:
        yield doctor.Finding(
            doctor.Grade.WARN,
            "ports",
            "this computer has no serial port",
            "plug the board in, or name --port",
        )
    for candidate in found:
        if candidate.answers:
            yield from _port(candidate.port.name, rate, seconds)
        else:
            yield doctor.Finding(
                doctor.Grade.WARN,
                "port",
                candidate.problem,
                "ignore this if no board is meant to be on that port",
            )


def _port(name: str, rate: float, seconds: float) -> Iterator["Finding"]:
    from daq.board_sample import sample_board
    from daq.errors import StationError
    from daq.port_facts import port_facts
    from station.operations import doctor

    facts = port_facts(name)
    yield from doctor.port(name, facts)
    if not facts.exists or not facts.permitted:
        return
    try:
        yield from doctor.board(sample_board(name, seconds, rate))
    except StationError as error:
        what, _, remedy = str(error).rpartition("; ")
        yield doctor.Finding(doctor.Grade.FAIL, "board", what or remedy, remedy if what else "")


def _print(findings: list["Finding"]) -> None:
    from rich.table import Table
    from rich.text import Text

    colours = {"PASS": "green", "WARN": "yellow", "FAIL": "red"}
    table = Table.grid(padding=(0, 1))
    for finding in findings:
        text = finding.found
        if finding.remedy and finding.grade != "PASS":
            text += f"\n-> {finding.remedy}"
        grade = Text(finding.grade.value, style=colours[finding.grade.value])
        table.add_row(grade, Text(finding.check), Text(text))
    screen().print(table)
