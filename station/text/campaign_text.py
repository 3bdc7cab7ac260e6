"""A campaign in 80 columns: what was found, every parameter's chart, trends, who is out, who failed."""

from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from station.results.campaign_document import CampaignDocument, CampaignRow, ChartDocument, TrendDocument
from station.text.campaign_progress import duration
from station.text.layout import labelled
from station.text.numbers import DASH, probability, three_figures, with_error, with_unit

LABEL_WIDTH = 12
MOST_TRENDS = 8
MOST_OUTSIDE = 10
MOST_FAILED = 10
LESS_SURE = 0.01


def show_campaign(console: Console, document: CampaignDocument) -> None:
    """Print a campaign."""
    console.print()
    console.print(Text(f" {headline(document)}", style="bold"))
    console.print()
    if document.charts:
        console.print(Padding(_charts(document.charts), (0, 0, 0, 1)))
        console.print()
    elif document.rows:
        console.print(Padding(_few(document.rows), (0, 0, 0, 1)))
        console.print()
    trends = worth_showing(document.trends)
    if trends:
        console.print(Padding(_trends(trends), (0, 0, 0, 1)))
        console.print()
    for label, text in _facts(document, trends):
        console.print(labelled(label, text, LABEL_WIDTH))
    console.print()


def headline(document: CampaignDocument) -> str:
    """Return how many sessions there are, and how many have no result."""
    done = "diagnosed" if document.diagnosed else "identified"
    failed = f", {len(document.failed)} failed" if document.failed else ""
    return f"{_sessions(len(document.rows))} {done}{failed}"


def _sessions(number: int) -> str:
    return f"{number} session{'s' * (number != 1)}"


def worth_showing(trends: list[TrendDocument]) -> list[TrendDocument]:
    """Return the trends that are sure, and after them those with p below 1 %, a few in all."""
    return [t for t in trends if t.sure or t.p_value < LESS_SURE][:MOST_TRENDS]


def _charts(charts: list[ChartDocument]) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    table.add_column("parameter", overflow="fold")
    table.add_column("median", justify="right", no_wrap=True)
    table.add_column("spread", justify="right", no_wrap=True)
    table.add_column("stated\nerror", justify="right", no_wrap=True)
    table.add_column("unit", no_wrap=True)
    table.add_column("n", justify="right", no_wrap=True)
    table.add_column("out", justify="right", no_wrap=True)
    for chart in charts:
        table.add_row(
            Text(chart.parameter),
            Text(_value(chart.centre, chart.spread)),
            three_figures(chart.spread),
            three_figures(chart.stated),
            Text("" if chart.unit == "1" else chart.unit),
            str(chart.sessions),
            Text(str(len(chart.outside)) if chart.outside else DASH, style="red" if chart.outside else ""),
        )
    return table


def _few(rows: list[CampaignRow]) -> Table:
    """Return the sessions themselves, where they are too few for charts."""
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    for head in ("session", "known of it", "amplitude", "stiffness K"):
        table.add_column(head, overflow="fold")
    for row in rows:
        known = ", ".join(f"{name} {value:g}" for name, value in row.conditions.items())
        found, size = row.result, row.result.amplitude
        estimate = found.parameters.get("wavelet.K")
        table.add_row(
            Text(found.session),
            Text(known or DASH),
            DASH if size is None else f"{three_figures(size)} {found.unit}",
            DASH if estimate is None else with_unit(estimate),
        )
    return table


def _value(value: float, error: float) -> str:
    return with_error(value, error).partition(" ")[0] if error > 0.0 else f"{value:.6g}"


def _trends(trends: list[TrendDocument]) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    table.add_column("trend", overflow="fold")
    table.add_column("slope", justify="right", no_wrap=True)
    table.add_column("unit", overflow="fold")
    table.add_column("p", justify="right", no_wrap=True)
    for trend in trends:
        style = "" if trend.sure else "dim"
        table.add_row(
            Text(f"{trend.parameter} against {trend.against}", style=style),
            Text(with_error(trend.slope, trend.std), style=style),
            Text(trend.unit, style=style),
            Text(probability(trend.p_value), style=style),
        )
    return table


def _facts(document: CampaignDocument, trends: list[TrendDocument]) -> list[tuple[str, str]]:
    facts = []
    if document.verdicts:
        facts.append(("verdicts", _counts(document.verdicts)))
    if document.names:
        facts.append(("named", _counts(document.names)))
    if document.trends and not any(trend.sure for trend in document.trends):
        looked_at = ", ".join(dict.fromkeys(t.against for t in document.trends))
        facts.append(("trends", f"none is sure among {len(document.trends)} (against {looked_at})"))
    elif any(not trend.sure for trend in trends):
        facts.append(("trends", f"dim: not sure after {len(document.trends)} were looked at"))
    facts += _outside(document)
    facts += [("failed", f"{one.session}: {one.reason}") for one in document.failed[:MOST_FAILED]]
    if len(document.failed) > MOST_FAILED:
        facts.append(("", f"and {len(document.failed) - MOST_FAILED} more"))
    facts.append(("time", _time(document)))
    facts.append(("kept in", document.folder))
    return facts


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
            found.setdefault(one.session, []).append((off, f"{chart.parameter}{far} {way}"))
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
    return (
        f"{_sessions(document.done)} in {duration(document.wall_s)} by {document.workers} "
        f"worker{'s' * (document.workers != 1)} "
        f"({duration(document.work_s)} of their time){kept}"
    )
