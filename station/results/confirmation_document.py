"""The confirmation by curves as a document: the prediction errors, part by part, and the effects that lower them."""

from typing import Literal

from pydantic import AliasPath, Field

from identify.curves.confirmation import Confirmation
from identify.curves.held_out import HeldOut
from station.results.documents import Number, Part

AMPLITUDES = ("large amplitudes", "middle amplitudes", "small amplitudes")


class PredictionErrors(Part):
    """Errors of a prediction, in % of the motion: of the envelope, of the phase, and of both together."""

    envelope_percent: Number = Field(validation_alias="envelope")
    phase_percent: Number = Field(validation_alias="phase")
    motion_percent: Number = Field(validation_alias="motion")


class PartErrors(PredictionErrors):
    """The same on one part that was left out: a session, or the large or small amplitudes of one."""

    part: str


class PredictedErrors(PredictionErrors):
    """The rms over all releases, or over all but the largest amplitudes of one record; and each part."""

    by_part: list[PartErrors]


class ConfirmedEffectDocument(Part):
    """An effect that predicts: the error of what it explains, in % of the motion, without and with it.

    It is better on so many of the `parts` that were left out. Its evidence against the model without it is `nats`; `rivals`
    are not distinguishable from it.
    """

    name: str
    title: str = Field(validation_alias=AliasPath("term", "effect", "title"))
    explains: Literal["frequency", "loss"]
    before_percent: Number = Field(validation_alias="before")
    after_percent: Number = Field(validation_alias="after")
    better: int
    parts: int
    rivals: list[str]
    nats: Number | None = None


class ConfirmationDocument(Part):
    """The confirmed effects; `usual` and `found` are the errors of the model as given and with the effects.

    In `one_record` the parts are its large, middle (where it is long enough for three) and small amplitudes. `undecided`
    names by "frequency" or "loss" laws that explain it and that are not distinguishable.
    """

    one_record: bool
    parts: int
    better: int
    usual: PredictedErrors
    found: PredictedErrors
    effects: list[ConfirmedEffectDocument]
    undecided: dict[str, list[str]]


def confirmation_document(found: Confirmation, sessions: tuple[str, ...]) -> ConfirmationDocument:
    """Make the document of a confirmation on some sessions."""
    names = _names(found, sessions)
    return ConfirmationDocument.of(
        found, usual=_errors(found.usual, names), found=_errors(found.found, names)
    )


def _names(found: Confirmation, sessions: tuple[str, ...]) -> tuple[str, ...]:
    """Name the parts: by their sessions, of which some may be too short to have a curve."""
    with_curve = tuple(sessions[place] for place in found.releases)
    if not found.one_record:
        return with_curve
    parts = AMPLITUDES if found.parts == len(AMPLITUDES) else (AMPLITUDES[0], AMPLITUDES[-1])
    return tuple(f"{with_curve[0]}, {part}" for part in parts) if len(sessions) > 1 else parts


def _errors(held: HeldOut, names: tuple[str, ...]) -> PredictedErrors:
    by_part = [PartErrors.of(one, part=name) for name, one in zip(names, held.predicted, strict=True)]
    kinds = {kind: held.typical(kind) for kind in ("envelope", "phase", "motion")}
    return PredictedErrors(by_part=by_part, **kinds)
