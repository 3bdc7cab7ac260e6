"""`station doctor`: is everything ready for a capture, and if not, what to do."""

from dataclasses import asdict

import click

from station import exits
from station.commands.options import JSON, declared, option
from station.output import next_line, print_json, say, screen
from station.settings import Settings

COLOURS = {"PASS": "green", "WARN": "yellow", "FAIL": "red"}


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
    from rich.table import Table
    from rich.text import Text

    from station.operations.doctor import examine

    findings = list(examine(port or settings.capture.port, settings.sessions, settings.capture.rate, seconds))
    failed = any(finding.grade == "FAIL" for finding in findings)
    if as_json:
        print_json({"ok": not failed, "findings": [asdict(finding) for finding in findings]})
        return exits.NO_BOARD if failed else exits.DONE
    table = Table.grid(padding=(0, 1))
    for finding in findings:
        text = finding.found
        if finding.remedy and finding.grade != "PASS":
            text += f"\n-> {finding.remedy}"
        grade = Text(finding.grade.value, style=COLOURS[finding.grade.value])
        table.add_row(grade, Text(finding.check), Text(text))
    screen().print(table)
    at = () if port is None else ("--port", port)
    if failed:
        say(f"{next_line('doctor', *at)} (once what failed is mended)")
    elif any(finding.check == "handshake" for finding in findings):
        say(next_line("capture", *at))
    else:
        say(f"{next_line('demo')} (no board is needed for it)")
    return exits.NO_BOARD if failed else exits.DONE
