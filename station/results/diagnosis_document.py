"""A diagnosis as a document: what `--json` prints and `results/diagnosis.json` keeps; one writer and one reader."""

from dataclasses import replace

from daq.session import Session
from identify.diagnosis.diagnose import Diagnosis
from identify.diagnosis.judgement import Verdict
from identify.diagnosis.nonparametric_force import NonparametricForce
from identify.diagnosis.suspect import Suspect
from identify.effects.effect import Kind
from identify.fitting.baseline import Baseline
from identify.fitting.corrected_faults import CorrectedFault
from identify.fitting.leave_one_out import LeftOut
from identify.fitting.model_error import ModelError, errors_of
from identify.model.model import Model
from station.results.documents import (
    Document,
    EstimateDocument,
    Number,
    Part,
    estimate_document,
    read_document,
    write_document,
)
from station.results.models import ModelFile, model_file

NAME = "diagnosis.json"
MOST_POINTS = 40
MOST_CURVES = 2
MORE_DATA = "Record at least eight seconds or ten cycles, from the largest amplitude that is safe."


class ModelSummary(Part):
    """The model that was diagnosed."""

    effects: list[str]
    equation: str
    parameters: dict[str, EstimateDocument]


class ErrorDocument(Part):
    """The three errors, the standard error of the floor of chi2, and how far the free run goes."""

    force_mse_percent: Number = None
    motion_percent: Number = None
    chi2: Number = None
    chi2_std: Number = None
    horizon_s: Number = None


class ChannelFloor(Part):
    """The noise of one channel, its standard error, and where it was seen."""

    std: Number
    uncertainty: Number
    unit: str
    source: str


class NoiseFloorDocument(Part):
    """The floor of chi2 with its standard error, and the noise of each channel (of the first session)."""

    chi2: float
    chi2_std: float
    channels: dict[str, ChannelFloor]


class SuspectDocument(Part):
    """One effect that the model may lack; `model` is the whole model with it, None where it is not fitted with it."""

    effect: str
    title: str
    kind: Kind
    channel: str | None
    error_after: Number
    evidence: Number
    p_value: Number
    parameters: dict[str, EstimateDocument]
    confusable_with: list[str]
    held_out_gain: Number
    plausible: bool
    claimed: bool
    model: ModelFile | None


class FindingDocument(Part):
    """A sensor's fault that every fit corrects, and that ought to be mended."""

    effect: str
    title: str
    channel: str | None
    parameters: dict[str, EstimateDocument]
    chi2_drop: Number
    what_to_do: str


class CurveDocument(Part):
    """The missing force per unit mass along one coordinate."""

    coordinate: str
    unit: str
    position: list[float]
    force_per_mass: list[Number]
    std: list[Number]


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


class DiagnosisDocument(Document):
    """What a model lacks; `rivals` are suspects that this record does not tell from the one that is named."""

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
    baseline = found.start
    fitted = model_file(baseline.fit, expressions)
    return DiagnosisDocument(
        format=1,
        sessions=list(names),
        model=ModelSummary(
            effects=fitted.names,
            equation=fitted.equation,
            parameters={
                name: EstimateDocument(value=value.value, std=value.std, unit=value.unit)
                for name, value in fitted.parameters.items()
            },
        ),
        error=_error(errors_of(baseline)),
        noise_floor=_noise_floor(baseline),
        verdict=found.verdict,
        named=list(found.named),
        rivals=list(found.suspects[0].rivals) if found.named else [],
        suspects=[_suspect(suspect, expressions) for suspect in found.suspects],
        together=list(found.together),
        findings=[_finding(fault) for fault in found.findings],
        error_with_named=_error(errors_of(replace(baseline, fit=found.final))),
        shape=None if found.shape is None else _shape(found.shape),
        held_out=None if left_out is None else _held_out(names, left_out),
        explanation=found.explanation,
        next_experiment=found.next_experiment,
        fitted=fitted,
    )


def refused_document(names: tuple[str, ...], model: Model, reason: str) -> DiagnosisDocument:
    """Return the same document for sessions that hold too little to fit anything."""
    return DiagnosisDocument(
        format=1,
        sessions=list(names),
        model=ModelSummary(effects=list(model.names), equation=model.equation, parameters={}),
        error=ErrorDocument(),
        noise_floor=None,
        verdict="not_enough_data",
        named=[],
        rivals=[],
        suspects=[],
        together=[],
        findings=[],
        error_with_named=None,
        shape=None,
        held_out=None,
        explanation=reason,
        next_experiment=MORE_DATA,
        fitted=None,
    )


def read_diagnosis(session: Session) -> DiagnosisDocument | None:
    """Return the diagnosis that a session keeps, None when it keeps none.

    Raises UsageProblem when it was altered or another version wrote it.
    """
    return read_document(session, NAME, DiagnosisDocument, "diagnose again")


def write_diagnosis(session: Session, document: DiagnosisDocument) -> None:
    """Write results/diagnosis.json."""
    write_document(session, NAME, document)


def _error(error: ModelError) -> ErrorDocument:
    return ErrorDocument(
        force_mse_percent=error.force_mse_percent,
        motion_percent=error.motion_percent,
        chi2=error.chi_square,
        chi2_std=error.floor_std,
        horizon_s=error.horizon_s,
    )


def _noise_floor(baseline: Baseline) -> NoiseFloorDocument:
    unit = baseline.fit.windows[0].unit
    units = {"displacement": unit, "velocity": f"{unit}/s", "acceleration": f"{unit}/s^2"}
    channels = {
        name: ChannelFloor(std=n.std, uncertainty=n.uncertainty, unit=units[name], source=n.source)
        for name, n in baseline.floors[0].channels.items()
    }
    return NoiseFloorDocument(chi2=1.0, chi2_std=baseline.spread, channels=channels)


def _suspect(suspect: Suspect, expressions: tuple[str, ...]) -> SuspectDocument:
    fitted_with_it = suspect.effect.name in suspect.fit.model
    return SuspectDocument(
        effect=suspect.effect.name,
        title=suspect.effect.title,
        kind=suspect.kind,
        channel=suspect.term.channel or None,
        error_after=suspect.error_after,
        evidence=suspect.evidence,
        p_value=suspect.p_value,
        parameters={name: estimate_document(value) for name, value in suspect.parameters.items()},
        confusable_with=list(suspect.confusable_with),
        held_out_gain=suspect.held_out_gain,
        plausible=suspect.plausible,
        claimed=suspect.claimed,
        model=model_file(suspect.fit, expressions) if fitted_with_it else None,
    )


def _finding(fault: CorrectedFault) -> FindingDocument:
    effect = fault.term.effect
    return FindingDocument(
        effect=effect.name,
        title=effect.title,
        channel=fault.term.channel or None,
        parameters={name: estimate_document(value) for name, value in fault.parameters.items()},
        chi2_drop=fault.drop,
        what_to_do=effect.confirming_test,
    )


def _shape(shape: NonparametricForce) -> ShapeDocument:
    return ShapeDocument(
        explained=shape.explained,
        coordinates=list(shape.coordinates),
        curves=[
            CurveDocument(
                coordinate=curve.coordinate,
                unit=curve.unit,
                position=curve.position[:MOST_POINTS].tolist(),
                force_per_mass=curve.force[:MOST_POINTS].tolist(),
                std=curve.std[:MOST_POINTS].tolist(),
            )
            for curve in shape.shapes[:MOST_CURVES]
        ],
    )


def _held_out(names: tuple[str, ...], left_out: tuple[LeftOut, ...]) -> list[HeldOutDocument]:
    return [
        HeldOutDocument(session=names[one.index], chi2=one.chi_square, motion_percent=one.motion_percent)
        for one in left_out
    ]
