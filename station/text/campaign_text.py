"""A campaign in 80 columns: what was found, every parameter's chart, trends, who is out, who failed; and its CSV tables."""

import csv
import io
from typing import Any

from daq.plain_text import counted
from identify.formatting import DASH, three_figures, with_error
from station.results.campaign_document import CampaignDocument, CampaignRow, ChartDocument, TrendDocument
from station.results.documents import picked
from station.text.content import Table, Told, facts
from station.text.numbers import amplitude_words, probability, typeset_unit, with_unit

MOST_TRENDS = 8
MOST_OUTSIDE = 10
MOST_FAILED = 10
LESS_SURE = 0.01

ERRORS = ("chi2", "chi2_std", "motion_percent", "chi2_named", "motion_percent_named")
TREND = ("parameter", "against", "slope", "std", "unit", "p_value", "sure", "sessions", "left_out")
LEADING = "=+-@\t\r"

SESSIONS, TRENDS = "sessions.csv", "trends.csv"


def told(document: CampaignDocument) -> Told:
    """Tell a campaign."""
    # Those that are sure, and after them those with p below 1 %.
    trends = [one for one in document.trends if one.sure or one.p_value < LESS_SURE][:MOST_TRENDS]
    tables = [_charts(document.charts)] if document.charts else [_few(document.rows)] if document.rows else []
    tables += [_trends(trends)] if trends else []
    return Told(headline(document), "", (*tables, *facts(_facts(document, trends))))


def headline(document: CampaignDocument) -> str:
    """Count how many sessions there are, and how many have no result."""
    done = "diagnosed" if document.diagnosed else "identified"
    failed = f", {len(document.failed)} failed" if document.failed else ""
    return f"{counted(len(document.rows), 'session', 'sessions')} {done}{failed}"


def _charts(charts: list[ChartDocument]) -> Table:
    rows = []
    for chart in charts:
        value = with_error(chart.centre, chart.spread) if chart.spread else f"{chart.centre:.6g} ± 0"
        unit, out = typeset_unit(chart.unit), str(len(chart.outside)) if chart.outside else DASH
        rows.append((chart.parameter, value, three_figures(chart.stated), unit, str(chart.sessions), out))
    return Table("", ("parameter", "median ± spread", "stated\nerror", "unit", "n", "out"), tuple(rows))


def _few(rows: list[CampaignRow]) -> Table:
    """Make the table of the sessions themselves, where they are too few for charts."""
    lines = []
    for row in rows:
        known = ", ".join(f"{name} {value:g}" for name, value in row.conditions.items())
        found, estimate = row.result, row.result.parameters.get("wavelet.K")
        amplitude = amplitude_words(found.amplitude, found.unit)
        lines.append(
            (found.session, known or DASH, amplitude, DASH if estimate is None else with_unit(estimate))
        )
    return Table("", ("session", "conditions", "amplitude", "stiffness K"), tuple(lines), texts=4)


def _trends(trends: list[TrendDocument]) -> Table:
    rows = tuple(
        (
            f"{one.parameter} against {one.against}",
            with_error(one.slope, one.std),
            typeset_unit(one.unit),
            probability(one.p_value),
        )
        for one in trends
    )
    return Table(
        "", ("trend", "slope", "unit", "p"), rows, marks=tuple("" if one.sure else "weak" for one in trends)
    )


def _facts(document: CampaignDocument, trends: list[TrendDocument]) -> list[tuple[str, str]]:
    found = []
    if document.verdicts:
        found.append(("verdicts", _counts(document.verdicts)))
    if document.names:
        found.append(("named", _counts(document.names)))
    if document.trends and not any(trend.sure for trend in document.trends):
        looked_at = ", ".join(dict.fromkeys(t.against for t in document.trends))
        found.append(("trends", f"none of {len(document.trends)} is significant (against {looked_at})"))
    elif any(not trend.sure for trend in trends):
        found.append(("trends", f"dimmed: not significant among the {len(document.trends)} tested"))
    found += _outside(document)
    found += [("failed", f"{one.session}: {one.reason}") for one in document.failed[:MOST_FAILED]]
    if len(document.failed) > MOST_FAILED:
        found.append(("", f"and {len(document.failed) - MOST_FAILED} more"))
    found.append(("time", _time(document)))
    found.append(("kept in", document.folder))
    return found


def _counts(counts: dict[str, int]) -> str:
    return ", ".join(f"{name} {count}" for name, count in counts.items())


def _outside(document: CampaignDocument) -> list[tuple[str, str]]:
    """Return a line for each session outside some limits, those furthest out first."""
    found: dict[str, list[tuple[float, str]]] = {}
    for chart in document.charts:
        for one in chart.outside:
            off = float("inf") if one.sigmas is None else abs(one.sigmas)
            way = "above" if one.value > chart.centre else "below"
            far = "" if one.sigmas is None else f" {off:.3g} spreads"
            found.setdefault(one.session, []).append((off, f"{chart.parameter}{far} {way} the median"))
    furthest = sorted(found.items(), key=lambda item: -max(off for off, _ in item[1]))
    lines = []
    for name, parts in furthest[:MOST_OUTSIDE]:
        told = [text for _, text in sorted(parts, key=lambda part: -part[0])]
        more = f" and {len(told) - 2} more" if len(told) > 2 else ""
        lines.append(("out", f"{name}: {', '.join(told[:2])}{more}"))
    if len(furthest) > MOST_OUTSIDE:
        lines.append(("", f"and {len(furthest) - MOST_OUTSIDE} more sessions"))
    return lines


def _time(document: CampaignDocument) -> str:
    if not document.done:
        return "nothing was missing or changed: all was kept from before"
    kept = f"; {document.kept} kept from before" if document.kept else ""
    done = counted(document.done, "session", "sessions")
    workers = counted(document.workers, "worker", "workers")
    work = f"{duration(document.work_s)} of computing"
    return f"{done} in {duration(document.wall_s)} by {workers} ({work}){kept}"


def duration(seconds: float) -> str:
    """Return a time as people say it: "46 s", "12 min", "3.4 h"."""
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 6000.0 else f"{seconds / 3600.0:.1f} h"


def sessions_csv(document: CampaignDocument) -> str:
    """Write every session with what is known of it, its errors, its verdict, and every parameter with its error."""
    conditions = list(dict.fromkeys(key for row in document.rows for key in row.conditions))
    rows = [_cells(row, conditions) for row in document.rows]
    rows += [{"session": one.session, "failed": one.reason} for one in document.failed]
    columns = dict.fromkeys(column for row in rows for column in row if column != "failed")
    return _written([*columns, "failed"], rows)


def trends_csv(document: CampaignDocument) -> str:
    """Write every trend that was looked for, the likeliest first."""
    return _written(list(TREND), [picked(trend, *TREND) for trend in document.trends])


def _cells(row: CampaignRow, conditions: list[str]) -> dict[str, Any]:
    """Write a session's cells by the name of their column."""
    result = row.result
    cells: dict[str, Any] = {"session": result.session, "made": row.made.isoformat()}
    cells |= {key: row.conditions.get(key) for key in conditions}
    cells |= {"amplitude": result.amplitude, "amplitude unit": result.unit}
    cells |= picked(result, *ERRORS)
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
