"""The tables of a campaign as CSV: one line a session, and one line a trend."""

import csv
import io
from typing import Any

from station.results.campaign_document import CampaignDocument, CampaignRow

ERRORS = ("chi2", "chi2_std", "motion_percent", "chi2_named", "motion_percent_named")
LEADING = "=+-@\t\r"

SESSIONS, TRENDS = "sessions.csv", "trends.csv"


def sessions_csv(document: CampaignDocument) -> str:
    """Return every session with what is known of it, its errors, its verdict, and every parameter with its error."""
    conditions = list(dict.fromkeys(key for row in document.rows for key in row.conditions))
    parameters = list(
        dict.fromkeys((name, e.unit) for row in document.rows for name, e in row.result.parameters.items())
    )
    columns = [("session", ""), ("made", ""), *((key, "") for key in conditions), ("amplitude", "")]
    header = [_heading(name, unit) for name, unit in columns] + [
        "amplitude unit",
        *ERRORS,
        "verdict",
        "named",
    ]
    for name, unit in parameters:
        header += [_heading(name, unit), _heading(f"{name} std", unit)]
    header.append("failed")
    lines = [_line(row, conditions, parameters) for row in document.rows]
    blank = len(header) - 2
    lines += [[_text(one.session), *([""] * blank), _text(one.reason)] for one in document.failed]
    return _written(header, lines)


def trends_csv(document: CampaignDocument) -> str:
    """Return every trend that was looked for, the likeliest first."""
    header = ["parameter", "against", "slope", "std", "unit", "p_value", "sure", "sessions", "left_out"]
    found = [[getattr(trend, name) for name in header] for trend in document.trends]
    return _written(
        header, [[_text(cell) if isinstance(cell, str) else cell for cell in line] for line in found]
    )


def _line(row: CampaignRow, conditions: list[str], parameters: list[tuple[str, str]]) -> list[Any]:
    result = row.result
    line: list[Any] = [_text(result.session), row.made.isoformat() if row.made else ""]
    line += [_number(row.conditions.get(key)) for key in conditions]
    line += [_number(result.amplitude), result.unit, *(_number(getattr(result, name)) for name in ERRORS)]
    line += [result.verdict or "", " + ".join(result.named)]
    for name, unit in parameters:
        estimate = result.parameters.get(name)
        there = estimate is not None and estimate.unit == unit
        line += [_number(estimate.value), _number(estimate.std)] if estimate and there else ["", ""]
    return [*line, ""]


def _heading(name: str, unit: str) -> str:
    return _text(f"{name} [{unit}]" if unit and unit != "1" else name)


def _number(value: float | None) -> str:
    return "" if value is None else repr(value)


def _text(text: str) -> str:
    """Return a text that a spreadsheet does not take for a formula."""
    return f"'{text}" if text[:1] in LEADING and text[:1] else text


def _written(header: list[str], lines: list[list[Any]]) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(lines)
    return out.getvalue()
