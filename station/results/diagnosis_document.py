"""A diagnosis as a document: what `--json` prints and `results/diagnosis.json` keeps; one writer and one reader."""

from dataclasses import replace
from typing import Any

from pydantic import AliasChoices, Field

from daq.session import Session
from identify.comparison.shared_physics import SharedPhysics
from identify.diagnosis.diagnose import Diagnosis
from identify.diagnosis.hypotheses import odds
from identify.diagnosis.next_release import NextRelease
from identify.diagnosis.nonparametric_force import NonparametricForce
from identify.diagnosis.suspect import Suspect
from identify.diagnosis.verdict import Verdict
from identify.effects.effect import Kind
from identify.fitting.baseline import Baseline
from identify.fitting.corrected_faults import CorrectedFault
from identify.fitting.model_error import errors_of
from identify.fitting.validation import LeftOut
from identify.model.model import Model
from identify.preprocessing.record_use import End
from station.results.confirmation_document import ConfirmationDocument, confirmation_document
from station.results.documents import (
    ChannelNoise,
    Document,
    Errors,
    EstimateDocument,
    Number,
    Numbers,
    Part,
    read_document,
    write_document,
)
from station.results.models import ModelFile, model_file
from station.results.shares_document import SharesDocument
from station.results.walk_document import WalkDocument

NAME = "diagnosis.json"
MOST_POINTS = 40
MOST_CURVES = 2
MORE_DATA = "Record at least eight seconds or ten cycles, from the largest amplitude that is safe."


class ModelSummary(Part):
    """The model that was diagnosed."""

    effects: list[str] = Field(validation_alias=AliasChoices("names", "effects"))
    equation: str
    parameters: dict[str, EstimateDocument]


class ErrorDocument(Errors):
    """The three errors, the standard error of the floor of chi2, and how far the free run goes."""

    chi2_std: Number = Field(None, validation_alias=AliasChoices("chi2_std", "floor_std"))
    horizon_s: Number = None


class ChannelFloor(ChannelNoise):
    """The noise of one channel with its unit."""

    unit: str


class HarmonicsDocument(Part):
    """Power of the residual at the motion's harmonics, relative to noise of the level between them, and its p-value."""

    ratio: Number
    p_value: Number
    against: bool


class NoiseFloorDocument(Part):
    """The floor of chi2 with its standard error, and the noise of each channel (of the first session).

    `sure` is false where the floor is a guess (one channel, or no rest); `harmonics` then says whether a residual near
    it speaks against the model, None where it was not asked.
    """

    chi2: float
    chi2_std: float
    channels: dict[str, ChannelFloor]
    sure: bool | None = None
    harmonics: HarmonicsDocument | None = None


class SuspectDocument(Part):
    """One effect that the model may lack; `model` is the whole model with it, None where it is not fitted with it.

    `confirmed` says whether it predicts what it was not fitted to, None where that was not asked or curves cannot show
    it; `rivals` are effects that explain the record, or predict, as well. `motion_percent` is what the model refitted
    with it leaves of the motion, `error_after` the same as chi2.
    """

    effect: str
    title: str
    kind: Kind
    channel: str | None
    error_after: Number
    evidence: Number
    parameters: dict[str, EstimateDocument]
    confusable_with: list[str]
    plausible: bool
    claimed: bool
    model: ModelFile | None
    confirmed: bool | None = None
    rivals: list[str] = Field(default_factory=list)
    motion_percent: Number = None
    strength_known: bool = True


class FindingDocument(Part):
    """A sensor's fault that every fit corrects, and that ought to be mended; `words` say what was found, in a clause."""

    effect: str
    title: str
    channel: str | None
    parameters: dict[str, EstimateDocument]
    chi2_drop: Number
    what_to_do: str
    words: str = ""


class CurveDocument(Part):
    """The missing force per unit mass along one coordinate."""

    coordinate: str
    unit: str
    position: Numbers
    force_per_mass: Numbers
    std: Numbers


class ShapeDocument(Part):
    """The free form of what has no name: the share of the rest that it explains, and its curves."""

    explained: float
    coordinates: list[str]
    curves: list[CurveDocument]


class HeldOutDocument(Part):
    """The error on one session of physics that was fitted to the others; None where the free run diverges."""

    session: str
    chi2: Number
    motion_percent: Number


class DifferenceDocument(Part):
    """In what a session, alone, differs from the first: in % of its value, and in standard errors."""

    session: str
    parameter: str
    percent: Number
    sigmas: Number


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

    frequency_hz: Number = Field(validation_alias=AliasChoices("frequency_hz", "frequency"))
    percent: Number
    channel: str
    words: str


class HypothesisDocument(Part):
    """What may be true: the effects beyond the model that was asked about, and the odds, 0 to 1 over all hypotheses."""

    names: list[str]
    title: str
    odds: Number


class NextReleaseDocument(Part):
    """The release that is expected to tell most `between` two hypotheses, with the evidence expected of it, nats.

    `amplitude` is signed, in `unit`; of a `push` what it swings to. `scatter` is the standard deviation; `same_nats` the
    evidence of the same amplitude again. `longer` and `faster` are multiples of the record's length and rate; `rested` means
    some seconds of rest before. `tells_more` is false where no release decides; `words` say all of it.
    """

    amplitude: Number
    unit: str
    push: bool
    longer: Number
    faster: Number
    rested: bool
    between: list[str]
    nats: Number
    scatter: Number
    same_nats: Number
    tells_more: bool
    words: str


class DiagnosisDocument(Document):
    """What a model lacks; `rivals` are suspects that this record does not tell from the one that is named.

    `confirmed` are those named effects that predict what they were not fitted to, `confirmation` how well, None where
    it was not asked. `fitted` is the model that was asked about, `final` the one with all that is named; None where nothing
    is.
    `differences` say in what several sessions, each alone, do not share their physics; None where it was not looked at.
    `used` says which part of each record was analysed; `modes` are other modes of the structure that it shows.
    `of_sessions` are the linear spring and damper of each session, where they differ and each has its own.
    `walk` is a random walk of spring and damper that a name is not told from, or that is left beside it; None elsewhere.
    `shares` are what each effect does at the largest and at the smallest amplitude; none where something has no name.
    `hypotheses` are what is left, the likeliest first; `next_release` would tell most between them, None where none can.
    `varies` is what was changed on purpose between the sessions; `left_out` says, by name, why a session holds too little.
    `model_is` says which model it is that was diagnosed, `model_remark` why it is not the one that was identified.
    """

    sessions: list[str]
    model: ModelSummary
    error: ErrorDocument
    noise_floor: NoiseFloorDocument | None
    verdict: Verdict
    named: list[str]
    rivals: list[str]
    suspects: list[SuspectDocument]
    together: list[str]
    findings: list[FindingDocument]
    error_with_named: ErrorDocument | None
    shape: ShapeDocument | None
    held_out: list[HeldOutDocument] | None
    explanation: str
    next_experiment: str
    fitted: ModelFile | None
    final: ModelFile | None = None
    differences: list[DifferenceDocument] | None = None
    confirmed: list[str] = Field(default_factory=list)
    confirmation: ConfirmationDocument | None = None
    shares: list[SharesDocument] = Field(default_factory=list)
    used: list[UsedDocument] = Field(default_factory=list)
    of_sessions: list[ReleaseValueDocument] = Field(default_factory=list)
    walk: WalkDocument | None = None
    modes: list[ModeDocument] = Field(default_factory=list)
    hypotheses: list[HypothesisDocument] = Field(default_factory=list)
    next_release: NextReleaseDocument | None = None
    varies: list[str] = Field(default_factory=list)
    left_out: dict[str, str] = Field(default_factory=dict)
    model_is: str = "the usual model"
    model_remark: str = ""


def diagnosis_document(
    names: tuple[str, ...],
    found: Diagnosis,
    expressions: tuple[str, ...] = (),
    left_out: tuple[LeftOut, ...] | None = None,
) -> DiagnosisDocument:
    """Return a diagnosis of some sessions as it is kept.

    `expressions` are the user's own effects; `left_out` are the errors of physics fitted to the other sessions, None
    with one session.
    """
    baseline, confirmation = found.baseline, found.confirmation
    fitted = model_file(baseline.stated(baseline.fit), expressions)
    return DiagnosisDocument.of(
        found,
        format=1,
        sessions=names,
        model=ModelSummary.model_validate(fitted),
        error=errors_of(baseline),
        noise_floor=_noise_floor(baseline) | {"harmonics": found.harmonics},
        rivals=found.suspects[0].rivals if found.named else (),
        confirmed=[] if confirmation is None else [n for n in found.named if n in confirmation.names],
        confirmation=None if confirmation is None else confirmation_document(confirmation, names),
        suspects=[_suspect(suspect, found, expressions) for suspect in in_order(found)],
        findings=[_finding(fault) for fault in found.findings],
        error_with_named=errors_of(replace(baseline, fit=found.final)),
        shape=None if found.shape is None else _shape(found.shape),
        held_out=None if left_out is None else _held_out(names, left_out),
        hypotheses=_hypotheses(found),
        next_release=next_release_document(found.next_release),
        fitted=fitted,
        final=model_file(baseline.stated(found.final), expressions) if found.named else None,
        used=_used(names, found),
        of_sessions=[ReleaseValueDocument.of(one, session=names[one.index]) for one in found.of_releases],
    )


def in_order(found: Diagnosis) -> list[Suspect]:
    """Return the suspects as they are shown everywhere: what is named, then its rivals, then by what each leaves.

    Those with values that make no sense, as hum at the motion's own frequency, come last. Where curves were asked, what
    they predict decides, and the diagnosis' own order stays.
    """
    if found.confirmation is not None:
        return list(found.suspects)
    named = list(found.named)
    rivals = found.suspects[0].rivals if named else ()

    def place(suspect: Suspect) -> tuple[int, bool, float]:
        name = suspect.effect.name
        if name in named:
            return named.index(name), False, 0.0
        return len(named) + (name not in rivals), not suspect.plausible, suspect.error_after

    return sorted(found.suspects, key=place)


def refused_document(names: tuple[str, ...], model: Model, reason: str) -> DiagnosisDocument:
    """Return the same document for sessions that hold too little to fit anything."""
    return DiagnosisDocument.model_validate(
        {
            "format": 1,
            "sessions": names,
            "model": {"effects": model.names, "equation": model.equation, "parameters": {}},
            "error": {},
            "verdict": "not_enough_data",
            "explanation": reason,
            "next_experiment": MORE_DATA,
            **dict.fromkeys(("named", "rivals", "suspects", "together", "findings"), ()),
            **dict.fromkeys(("noise_floor", "error_with_named", "shape", "held_out", "fitted")),
        }
    )


def with_differences(document: DiagnosisDocument, shared: SharedPhysics) -> DiagnosisDocument:
    """Return a diagnosis with what was found of its sessions before it: in what each, alone, differs from the first."""
    differences = [
        DifferenceDocument.of(one, session=document.sessions[one.index]) for one in shared.differences
    ]
    return document.model_copy(update={"differences": differences})


def read_diagnosis(session: Session) -> DiagnosisDocument | None:
    """Return the diagnosis that a session keeps, None when it keeps none.

    Raises UsageProblem when it was altered or another version wrote it.
    """
    return read_document(session, NAME, DiagnosisDocument, "diagnose again")


def write_diagnosis(session: Session, document: DiagnosisDocument) -> None:
    """Write results/diagnosis.json."""
    write_document(session, NAME, document)


def _noise_floor(baseline: Baseline) -> dict[str, Any]:
    unit = baseline.fit.windows[0].unit
    units = {"displacement": unit, "velocity": f"{unit}/s", "acceleration": f"{unit}/s^2"}
    channels = {
        name: {"std": n.std, "uncertainty": n.uncertainty, "unit": units[name], "source": n.source}
        for name, n in baseline.floors[0].channels.items()
    }
    return {"chi2": 1.0, "chi2_std": baseline.spread, "channels": channels, "sure": baseline.floor_is_sure}


def _used(names: tuple[str, ...], found: Diagnosis) -> list[UsedDocument]:
    uses = zip(names, (decay.use for decay in found.decays), strict=False)
    return [UsedDocument.of(use, session=name) for name, use in uses if use is not None]


def _suspect(suspect: Suspect, found: Diagnosis, expressions: tuple[str, ...]) -> SuspectDocument:
    confirmation = found.confirmation
    name = suspect.effect.name
    is_fitted = name in suspect.fit.model
    asked = confirmation is not None and confirmation.has_law(name)
    return SuspectDocument.of(
        suspect,
        effect=name,
        title=suspect.effect.title,
        channel=suspect.term.channel or None,
        model=model_file(suspect.stated, expressions) if is_fitted else None,
        confirmed=suspect.confirmed is not None if asked else None,
        motion_percent=suspect.motion_after,
    )


def _hypotheses(found: Diagnosis) -> list[dict[str, Any]]:
    chances = odds(found.hypotheses)
    return [
        {"names": one.names, "title": one.title, "odds": chance}
        for one, chance in zip(found.hypotheses, chances.tolist(), strict=True)
    ]


def next_release_document(chosen: NextRelease | None) -> NextReleaseDocument | None:
    """Return a chosen release as it is kept; None where none was chosen."""
    if chosen is None:
        return None
    best, same_nats = chosen.best, None if chosen.same is None else chosen.same.nats
    experiment = vars(best.experiment)
    return NextReleaseDocument.of(
        chosen, nats=best.nats, scatter=best.scatter, same_nats=same_nats, **experiment
    )


def _finding(fault: CorrectedFault) -> FindingDocument:
    effect = fault.term.effect
    return FindingDocument.of(
        fault,
        effect=effect.name,
        title=effect.title,
        channel=fault.term.channel or None,
        chi2_drop=fault.drop,
        what_to_do=effect.confirming_test,
    )


def _shape(shape: NonparametricForce) -> ShapeDocument:
    curves = [
        CurveDocument.of(
            curve,
            position=curve.position[:MOST_POINTS],
            force_per_mass=curve.force[:MOST_POINTS],
            std=curve.std[:MOST_POINTS],
        )
        for curve in shape.shapes[:MOST_CURVES]
    ]
    return ShapeDocument.of(shape, curves=curves)


def _held_out(names: tuple[str, ...], left_out: tuple[LeftOut, ...]) -> list[HeldOutDocument]:
    return [HeldOutDocument.of(one, session=names[one.index], chi2=one.chi_square) for one in left_out]
