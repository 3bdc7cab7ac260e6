"""A guided test as a document: what was released and why, and the odds after each release."""

from typing import Any

from pydantic import Field

from identify.diagnosis.guidance import State
from station.results.diagnosis_document import HypothesisDocument
from station.results.documents import Document, Number, Part

NAME = "guide.json"


class TurnDocument(Part):
    """One release: why it was asked for, what it gave.

    `amplitude` (signed, in `unit`) as asked for; `provisional` is the answer while the decay was still running, "" where
    there was none in time; `hypotheses` have their odds after it; `judged_s` is how long after its end the verdict came.
    `between` are the two hypotheses that it was to distinguish, none where it was to show what can hide; of `expected_nats`
    it gave `gave_nats`.
    `problem` says why a release gave no result.
    """

    session: str
    asked: str
    amplitude: Number
    unit: str
    verdict: str = ""
    named: list[str] = Field(default_factory=list)
    provisional: str = ""
    hypotheses: list[HypothesisDocument] = Field(default_factory=list)
    next_release: dict[str, Any] | None = None
    judged_s: Number = None
    between: list[str] = Field(default_factory=list)
    expected_nats: Number = None
    gave_nats: Number = None
    problem: str = ""


class GuideDocument(Document):
    """A guided test: its limits (in the unit of the displacement), its releases in order, and how it ended, in words."""

    folder: str
    low: Number
    high: Number
    state: State
    words: str
    named: list[str] = Field(default_factory=list)
    turns: list[TurnDocument] = Field(default_factory=list)
    report: str | None = None
    campaign: str | None = None
