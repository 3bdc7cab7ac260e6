"""What each effect does at the largest and at the smallest amplitude, as a document."""

from pydantic import AliasChoices, Field

from station.results.documents import EstimateDocument, Number, Part


class EffectShareDocument(Part):
    """What one force does over a cycle: its largest force, its part of the loss, by how much it raises the frequency."""

    effect: str
    force: EstimateDocument
    force_percent: EstimateDocument
    loss_percent: EstimateDocument
    frequency_hz: EstimateDocument
    frequency_percent: EstimateDocument


class SharesDocument(Part):
    """The shares of all forces but the linear spring at one amplitude, in `unit`, and the frequency of the motion there."""

    amplitude: Number
    unit: str
    frequency_hz: Number = Field(validation_alias=AliasChoices("frequency_hz", "frequency"))
    effects: list[EffectShareDocument]
