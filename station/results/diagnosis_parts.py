"""The parts of a diagnosis as a document."""

from typing import Annotated, Any

from pydantic import AliasPath, BeforeValidator, Field

from identify.effects.effect import Kind
from identify.preprocessing.record_use import End
from station.results.documents import EstimateDocument, Number, Numbers, Part
from station.results.models import ModelFile

Channel = Annotated[
    str | None,
    BeforeValidator(lambda name: name or None),
    Field(validation_alias=AliasPath("term", "channel")),
]
"""The channel at fault, None for a force."""


class NoiseFloorDocument(Part):
    """The floor of chi2 with its standard error, and the noise of each channel (of the first session).

    `sure` is false where the floor is a guess (one channel, or no rest); `harmonics` then says whether a residual near
    it speaks against the model: its power there, relative to that expected from between them. None where it was not asked.
    """

    chi2: float
    chi2_std: float
    channels: dict[str, Any]
    sure: bool | None = None
    harmonics: dict[str, Any] | None = None


class SuspectDocument(Part):
    """One effect that the model may lack; `model` is the whole model with it, None where it is not fitted with it.

    `confirmed` says whether it predicts what it was not fitted to, None where that was not asked or curves cannot show
    it; `rivals` are effects that explain the record, or predict, as well. `motion_percent` is what the model refitted
    with it leaves of the motion, `error_after` the same as chi2.
    """

    effect: str = Field(validation_alias=AliasPath("effect", "name"))
    title: str = Field(validation_alias=AliasPath("effect", "title"))
    kind: Kind
    channel: Channel
    error_after: Number
    evidence: Number
    parameters: dict[str, EstimateDocument]
    confusable_with: list[str]
    plausible: bool
    claimed: bool
    model: ModelFile | None
    confirmed: bool | None = None
    rivals: list[str] = Field(default_factory=list)
    motion_percent: Number = Field(None, validation_alias="motion_after")
    strength_known: bool = True


class FindingDocument(Part):
    """A sensor's fault that every fit corrects, and that ought to be mended; `words` say what was found, in a clause."""

    effect: str = Field(validation_alias=AliasPath("term", "effect", "name"))
    title: str = Field(validation_alias=AliasPath("term", "effect", "title"))
    channel: Channel
    parameters: dict[str, EstimateDocument]
    what_to_do: str = Field(validation_alias=AliasPath("term", "effect", "confirming_test"))
    words: str = ""


class CurveDocument(Part):
    """The missing force per unit mass along one coordinate."""

    coordinate: str
    unit: str
    position: Numbers
    force_per_mass: Numbers = Field(validation_alias="force")
    std: Numbers


class ShapeDocument(Part):
    """The free-form force without a name: the share of the residual that it explains, and its curves."""

    explained: float
    coordinates: list[str]
    curves: list[CurveDocument] = Field(validation_alias="shapes")


class HeldOutDocument(Part):
    """The error on one session of physics that was fitted to the others; None where the free run diverges."""

    session: str
    chi2: Number = Field(validation_alias="chi_square")
    motion_percent: Number


class ReleaseValueDocument(Part):
    """A parameter of the final model as one session has it, and by how much that is off the one of all, in %."""

    session: str
    parameter: str
    value: EstimateDocument
    percent: Number


class UsedDocument(Part):
    """The part of a session's record that was analysed, s from its first reading, and why it ends there.

    `share` is that part of what follows the release; `missing_s` how long readings are missing where that ends it.
    """

    session: str
    begin_s: Number
    end_s: Number
    length_s: Number
    share: Number
    ended: End
    missing_s: Number
    words: str


class ModeDocument(Part):
    """Another mode of the structure: its frequency, and its amplitude in % of the motion in one channel at first."""

    frequency_hz: Number = Field(validation_alias="frequency")
    percent: Number
    channel: str
    words: str


class HypothesisDocument(Part):
    """A hypothesis: the effects beyond the model that was diagnosed, and the odds, 0 to 1 over all hypotheses."""

    names: list[str]
    title: str
    odds: Number


class EffectShareDocument(Part):
    """One force over a cycle: its largest value, its part of the loss, and by how much it raises the frequency."""

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
    frequency_hz: Number = Field(validation_alias="frequency")
    effects: list[EffectShareDocument]
