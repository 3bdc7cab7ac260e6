"""The tables of a campaign as CSV: one line a session, and one line a trend."""

import csv
import io
from typing import Any

from station.results.campaign_document import CampaignDocument, CampaignRow

ERRORS = ("chi2", "chi2_std", "motion_percent", "chi2_named", "motion_percent_named")
TREND = ("parameter", "against", "slope", "std", "unit", "p_value", "sure", "sessions", "left_out")
LEADING = "=+-@\t\r"

SESSIONS, TRENDS = "sessions.csv", "trends.csv"


def sessions_csv(document: CampaignDocument) -> str:
    """Write every session with what is known of it, its errors, its verdict, and every parameter with its error."""
    conditions = list(dict.fromkeys(key for row in document.rows for key in row.conditions))
    rows = [_cells(row, conditions) for row in document.rows]
    rows += [{"session": one.session, "failed": one.reason} for one in document.failed]
    columns = dict.fromkeys(column for row in rows for column in row if column != "failed")
    return _written([*columns, "failed"], rows)


def trends_csv(document: CampaignDocument) -> str:
    """Write every trend that was looked for, the likeliest first."""
    return _written(
        list(TREND), [{name: getattr(trend, name) for name in TREND} for trend in document.trends]
    )


def _cells(row: CampaignRow, conditions: list[str]) -> dict[str, Any]:
    """Write a session's cells by the name of their column."""
    result = row.result
    cells: dict[str, Any] = {"session": result.session, "made": row.made.isoformat()}
    cells |= {key: row.conditions.get(key) for key in conditions}
    cells |= {"amplitude": result.amplitude, "amplitude unit": result.unit}
    cells |= {name: getattr(result, name) for name in ERRORS}
    cells |= {"verdict": result.verdict, "named": " + ".join(result.named)}
    for name, found in result.parameters.items():
        unit = f" [{found.unit}]" if found.unit not in ("", "1") else ""
        cells |= {f"{name}{unit}": found.value, f"{name} std{unit}": found.std}
    return cells


def _written(columns: list[str], rows: list[dict[str, Any]]) -> str:
    """Write rows as CSV; what a spreadsheet would take for a formula becomes a text."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    lines: list[list[Any]] = [[*columns], *([row.get(column) for column in columns] for row in rows)]
    for cells in lines:
        writer.writerow([f"'{c}" if isinstance(c, str) and c[:1] in LEADING and c else c for c in cells])
    return out.getvalue()
