"""Many sessions together: every parameter's control chart, and its trends against all known facts."""

import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from daq.session import SessionSummary
from daq.storage import write_whole
from identify.arrays import Array
from station.campaign.metadata import Known
from station.campaign.run import Run, Watch, run_campaign
from station.campaign.statistics import WIDTH, control_limits, find_trend, sure_ones
from station.results.campaign_document import (
    NAME,
    CampaignDocument,
    CampaignRow,
    ChartDocument,
    OutsideDocument,
    SessionResult,
    TrendDocument,
)
from station.settings import Settings
from station.story.pipeline import silent
from station.text import campaign_text as table

AMPLITUDE, DATE, MISFIT = "amplitude", "date", "motion misfit"
NAME_AND_UNIT = re.compile(r"(.*?)\s*[\[(]([^\])]*)[\])]\s*")
DAY = 86400.0


@dataclass(frozen=True, eq=False)
class Series:
    """One number of every session, NaN where a session has none, with its standard errors (n,)."""

    name: str
    unit: str
    values: Array
    std: Array


def campaign(
    sources: tuple[SessionSummary, ...],
    settings: Settings,
    folder: Path,
    workers: int,
    watch: Watch = silent,
    metadata: dict[str, Known] | None = None,
    *,
    diagnose: bool = False,
) -> CampaignDocument:
    """Bring the results of all sources up to date, and keep what they say together; arguments as `run_campaign`."""
    run = run_campaign(sources, settings, folder, workers, watch, diagnose=diagnose)
    document = campaign_document(folder, diagnose, run, metadata)
    files = {NAME: document.model_dump_json(indent=1) + "\n"}
    files |= {table.SESSIONS: table.sessions_csv(document), table.TRENDS: table.trends_csv(document)}
    for name, content in files.items():
        write_whole(folder / name, content.encode())
    return document


def campaign_document(
    folder: Path, diagnosed: bool, run: Run, metadata: dict[str, Known] | None = None
) -> CampaignDocument:
    """Put the findings of a run together; `metadata` are the operator's by `names_known` and come before the sessions'."""
    rows = sorted(
        (_row(source, result, metadata or {}) for source, result in run.results),
        key=lambda row: (row.made.timestamp(), row.result.session),
    )
    parameters = parameter_series(rows)
    named = Counter(name for row in rows for name in row.result.named)
    verdicts = Counter(row.result.verdict for row in rows if row.result.verdict)
    return CampaignDocument.of(
        run,
        format=1,
        folder=str(folder),
        diagnosed=diagnosed,
        rows=rows,
        failed=sorted(run.failed, key=lambda one: one.session),
        verdicts={str(verdict): count for verdict, count in verdicts.most_common()},
        names=dict(named.most_common()),
        charts=[chart for series in parameters if (chart := _chart(series, rows)) is not None],
        trends=_trends(parameters, variables(rows)),
    )


def names_known(source: SessionSummary) -> tuple[str, ...]:
    """Return the names under which the operator's table may have a session: its own, and that of its file."""
    return source.folder.name, source.info.source_file if source.info else ""


def _row(source: SessionSummary, result: SessionResult, metadata: dict[str, Known]) -> CampaignRow:
    assert source.info is not None  # it has a result
    known = next((metadata[name] for name in names_known(source) if name in metadata), Known())
    mass = {} if source.info.mass_kg is None else {"mass [kg]": source.info.mass_kg}
    conditions = mass | source.info.conditions | known.conditions
    return CampaignRow(made=known.date or source.info.created, conditions=conditions, result=result)


def parameter_series(rows: list[CampaignRow]) -> list[Series]:
    """Return every parameter over the sessions, and the misfit; one that has two units is two."""
    found: dict[tuple[str, str], Series] = {}
    for place, row in enumerate(rows):
        for name, estimate in row.result.parameters.items():
            series = found.setdefault((name, estimate.unit), _unknown(name, estimate.unit, len(rows)))
            series.values[place], series.std[place] = estimate.value, estimate.std
    misfit = _unknown(MISFIT, "%", len(rows))
    misfit.values[:] = [row.result.motion_percent for row in rows]
    return [*found.values(), *([misfit] if np.isfinite(misfit.values).any() else [])]


def _unknown(name: str, unit: str, count: int) -> Series:
    return Series(name, unit, np.full(count, np.nan), np.full(count, np.nan))


def variables(rows: list[CampaignRow]) -> list[Series]:
    """List what parameters may depend on: amplitude, date and every number that is known of the tests."""
    found: list[tuple[str, str, Sequence[float | None]]] = []
    for unit in dict.fromkeys(row.result.unit for row in rows):
        values = [row.result.amplitude if row.result.unit == unit else None for row in rows]
        found.append((AMPLITUDE, unit, values))
    found.append((DATE, "day", [row.made.timestamp() / DAY for row in rows]))
    for key in dict.fromkeys(key for row in rows for key in row.conditions):
        parts = NAME_AND_UNIT.fullmatch(key)
        name, unit = parts.groups() if parts else (key, "unit")
        found.append((name, unit, [row.conditions.get(key) for row in rows]))
    return [Series(name, unit, np.array(values, dtype=float), np.zeros(0)) for name, unit, values in found]


def _chart(series: Series, rows: list[CampaignRow]) -> ChartDocument | None:
    there = np.flatnonzero(np.isfinite(series.values))
    found = control_limits(series.values[there])
    if found is None:
        return None
    centre, spread, is_outside = found
    outside = [
        OutsideDocument(
            session=rows[i].result.session,
            value=float(series.values[i]),
            std=float(series.std[i]),
            sigmas=float((series.values[i] - centre) / spread) if spread else math.inf,
        )
        for i in there[is_outside]
    ]
    known = series.std[there][np.isfinite(series.std[there])]
    return ChartDocument(
        parameter=series.name,
        unit=series.unit,
        sessions=len(there),
        centre=centre,
        spread=spread,
        lower=centre - WIDTH * spread,
        upper=centre + WIDTH * spread,
        stated=float(np.median(known)) if len(known) else None,
        outside=outside,
    )


def _trends(parameters: list[Series], against: list[Series]) -> list[TrendDocument]:
    found = [
        (parameter, variable, trend)
        for parameter in parameters
        for variable in against
        if (trend := find_trend(variable.values, parameter.values, parameter.std)) is not None
    ]
    sure = sure_ones([trend.p_value for _, _, trend in found])
    documents = [
        TrendDocument.of(
            trend,
            parameter=parameter.name,
            against=variable.name,
            unit=f"{parameter.unit} per {variable.unit}",
            sure=is_sure,
        )
        for (parameter, variable, trend), is_sure in zip(found, sure, strict=True)
    ]
    return sorted(documents, key=lambda one: one.p_value)
