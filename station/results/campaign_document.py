"""A campaign as documents: the result of each session, kept as soon as it is done, and what they say together."""

from datetime import datetime

from pydantic import Field

from identify.judging.verdict import Verdict
from station.results.documents import Document, EstimateDocument, Number, Part, RefusedSession

NAME = "campaign.json"


class SessionResult(Document):
    """The results of one session.

    `key` is a checksum of the session's content and of the settings; `seconds` is the worker's time; `reason` says why
    there is no parameter, "" where there is one. `parameters` are by "wavelet.K" or "effect.parameter"; the errors are
    those of the usual model, and those with what the diagnosis named. `amplitude` (m or rad) is the largest.
    """

    session: str
    key: str
    seconds: float
    unit: str = "m"
    amplitude: Number = None
    parameters: dict[str, EstimateDocument] = Field(default_factory=dict)
    chi2: Number = None
    chi2_std: Number = None
    motion_percent: Number = None
    at_floor: bool | None = None
    verdict: Verdict | None = None
    named: list[str] = Field(default_factory=list)
    chi2_named: Number = None
    motion_percent_named: Number = None
    reason: str = ""
    refusals: dict[str, str] = Field(default_factory=dict)


class CampaignRow(Part):
    """One session of the table: its result, and the numbers known of the test, such as "temperature [degC]"."""

    made: datetime
    conditions: dict[str, float]
    result: SessionResult


class OutsideDocument(Part):
    """A session outside the control limits; `sigmas` is how far it lies from the centre in units of the spread."""

    session: str
    value: float
    std: Number
    sigmas: Number


class ChartDocument(Part):
    """One parameter over all sessions, in the order in which they were made: an individuals chart.

    `centre` is the median, `spread` the median moving range / 0.9539; the limits `lower` and `upper` are three spreads
    away. `stated` is the median of the stated standard errors.
    """

    parameter: str
    unit: str
    sessions: int
    centre: float
    spread: float
    lower: float
    upper: float
    stated: Number
    outside: list[OutsideDocument]


class Trend(Part):
    """A line by weighted least squares: `slope` with its standard error, and `p_value` of a slope of zero.

    `left_out` sessions lay too far off the line to be part of it.
    """

    slope: float
    std: float
    p_value: float
    sessions: int
    left_out: int


class TrendDocument(Trend):
    """A parameter against something else known of the sessions; the slope is in `unit`, as "1/s^2 per degC".

    `sure` where `p_value` is below 5 % after the number of trends that were looked at (Holm).
    """

    parameter: str
    against: str
    unit: str
    sure: bool


class CampaignDocument(Document):
    """Many sessions together; `wall_s` is what this run took, `work_s` the workers' time for what it did."""

    folder: str
    diagnosed: bool
    workers: int
    done: int
    kept: int
    wall_s: float
    work_s: float
    rows: list[CampaignRow]
    failed: list[RefusedSession]
    verdicts: dict[str, int]
    names: dict[str, int]
    charts: list[ChartDocument]
    trends: list[TrendDocument]
