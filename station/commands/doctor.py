"""`station doctor`: check computer, port and board before a capture."""

from dataclasses import asdict

import click

from station import exits
from station.commands.options import declared, option
from station.settings import Settings

MARKS = {"PASS": "", "WARN": "unsure", "FAIL": "bad"}


@declared("doctor")
def command(
    settings: Settings,
    port: str | None = option(
        "Port of the board (default: the settings', or each that answers).", metavar="URL"
    ),
    seconds: float = option(
        "How long to sample.", type=click.FloatRange(min=1, max=60), default=2.0, show_default=True
    ),
) -> int:
    """Check the computer, the port and the board: PASS, WARN or FAIL, and the remedy.

    Ends with 0 unless a check FAILs, with 3 then.
    """
    from station.operations.doctor import examine
    from station.text.content import Table, Told
    from station.text.layout import answer

    findings = list(examine(port or settings.capture.port, settings.sessions, settings.capture.rate, seconds))
    failed = any(finding.grade == "FAIL" for finding in findings)
    remedies = ["" if one.grade == "PASS" or not one.remedy else f"\n-> {one.remedy}" for one in findings]
    rows = tuple(
        (one.grade, one.check, f"{one.found}{remedy}") for one, remedy in zip(findings, remedies, strict=True)
    )
    table = Table("", ("", "", ""), rows, texts=3, marks=tuple(MARKS[one.grade] for one in findings))
    at = () if port is None else ("--port", port)
    answers = any(finding.check == "handshake" for finding in findings)
    step = ("doctor", *at) if failed else ("capture", *at) if answers else ("demo",)
    document = {"ok": not failed, "findings": [asdict(finding) for finding in findings]}
    answer(document, Told("", "", (table,)), *step)
    return exits.NO_BOARD if failed else exits.DONE
