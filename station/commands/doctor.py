"""`station doctor`: is everything ready for a capture, and if not, what to do."""

from dataclasses import asdict
from typing import TYPE_CHECKING

import click

from station import exits
from station.commands.options import JSON, declared, option
from station.output import next_line, print_json, say, screen
from station.settings import Settings

if TYPE_CHECKING:
    from station.operations.doctor import Finding


@declared("doctor")
def command(
    settings: Settings,
    port: str | None = option(
        "Port of the board (default: the settings', or each that answers).", metavar="URL"
    ),
    seconds: float = option(
        "How long to sample.", type=click.FloatRange(min=1, max=60), default=2.0, show_default=True
    ),
    as_json: bool = JSON,
) -> int:
    """Check the computer, the port and the board: PASS, WARN or FAIL, and the remedy.

    Ends with 0 unless a check FAILs, with 3 then.
    """
    from station.operations.doctor import examine

    findings = list(examine(port or settings.capture.port, settings.sessions, settings.capture.rate, seconds))
    failed = any(finding.grade == "FAIL" for finding in findings)
    if as_json:
        print_json({"ok": not failed, "findings": [asdict(finding) for finding in findings]})
    else:
        _print(findings)
        say(_next(findings, port, failed=failed))
    return exits.NO_BOARD if failed else exits.DONE


def _next(findings: list["Finding"], port: str | None, *, failed: bool) -> str:
    """Return the command that comes next: a capture where a board answered, the same check once a fault is mended."""

    at = () if port is None else ("--port", port)
    if failed:
        return f"{next_line('doctor', *at)} (once what failed is mended)"
    if any(finding.check == "handshake" for finding in findings):
        return next_line("capture", *at)
    return f"{next_line('demo')} (no board is needed for it)"


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
