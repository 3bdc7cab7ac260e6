"""A diagnosis as a document: what `--json` prints and `results/diagnosis.json` keeps; one writer and one reader."""

from collections.abc import Sequence
from typing import Annotated, Any

from pydantic import AliasPath, BeforeValidator, Field

from daq.session import Session
from identify.diagnosis.diagnose import MORE_DATA, Diagnosis
from identify.effects.effect import Kind
from identify.fitting.model_error import errors_of
from identify.fitting.prediction import Prediction
from identify.judging.suspect import Suspect
from identify.judging.verdict import Verdict
from identify.model.model import Model
from identify.planning.hypotheses import odds
from identify.planning.next_release import NextRelease
from identify.preprocessing.record_use import End
from station.results.confirmation_document import ConfirmationDocument, confirmation_document
from station.results.documents import (
    Document,
    Errors,
    EstimateDocument,
    ModelSummary,
    Number,
    Numbers,
    Part,
    picked,
    plain,
    read_document,
)
from station.results.models import ModelFile, model_file

NAME = "diagnosis.json"


Channel = Annotated[
    str | None,
    BeforeValidator(lambda name: name or None),
    Field(validation_alias=AliasPath("term", "channel")),
]
"""The channel at fault, None for a force."""


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


class DecidedDocument(Part):
    """What the table of verdicts weighed, in nats beyond a random walk of spring and damper, and what it decided.

    `names` are the laws that are not distinguishable; `unnamed` is a law outside the library in their place, `beside` one
    beside the first of them, None where that was not weighed. Curves weigh what `explains` the "frequency" or the "loss".
    """

    verdict: str
    explains: str
    nats: dict[str, Number]
    names: list[str]
    unnamed: Number
    beside: Number


class CurveDocument(Part):
    """The missing force per unit mass along one coordinate; `where` is the displacement or velocity that it belongs to."""

    coordinate: str
    unit: str
    position: Numbers
    force_per_mass: Numbers = Field(validation_alias="force")
    std: Numbers
    where: str = ""


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


class DiagnosisDocument(Document):
    """The effect that a model lacks; `rivals` are suspects that this record does not distinguish from the named one.

    `confirmed` are those named effects that predict what they were not fitted to, `confirmation` how well, None where
    it was not asked. `fitted` is the model that was asked about, `final` the one with all that is named; None where nothing
    is.
    `noise_floor` has the standard error of the floor of chi2, which is 1, and the noise of each channel (of the first
    session); it is not `sure` where it is a guess (one channel, or no rest), and `harmonics` then says whether a residual
    near it speaks against the model: its power there, relative to that expected from between them, None where not asked.
    `used` says which part of each record was analysed; `modes` are other modes of the structure that it shows.
    `of_sessions` are the linear spring and damper of each session, where they differ and each has its own.
    `walk` is a random walk of spring and damper that remains beside the name or, without one, explains all of the misfit:
    its evidence (nats), its standard deviations after one second, and the reduced chi-square beside it. None elsewhere.
    `caution` is what to keep in mind.
    `shares` are what each effect does at the largest and at the smallest amplitude; none where something has no name.
    `hypotheses` are those still open, the likeliest first; `next_release` distinguishes them best, None where none can.
    `varies` is what was changed on purpose between the sessions; `left_out` says, by name, why a session holds too little.
    `model_is` says which model it is that was diagnosed, `model_remark` why it is not the one that was identified.
    """

    sessions: list[str]
    model: ModelSummary
    error: Errors
    noise_floor: dict[str, Any] | None
    verdict: Verdict
    named: list[str]
    rivals: list[str]
    suspects: list[SuspectDocument]
    findings: list[FindingDocument]
    error_with_named: Errors | None
    shape: ShapeDocument | None
    held_out: list[HeldOutDocument] | None
    explanation: str
    next_experiment: str
    fitted: ModelFile | None
    final: ModelFile | None = None
    confirmed: list[str] = Field(default_factory=list)
    confirmation: ConfirmationDocument | None = None
    shares: list[SharesDocument] = Field(default_factory=list)
    used: list[UsedDocument] = Field(default_factory=list)
    of_sessions: list[ReleaseValueDocument] = Field(default_factory=list)
    walk: dict[str, Any] | None = None
    decided: list[DecidedDocument] = Field(default_factory=list)
    caution: str = ""
    modes: list[dict[str, Any]] = Field(default_factory=list)
    hypotheses: list[HypothesisDocument] = Field(default_factory=list)
    next_release: dict[str, Any] | None = None
    varies: list[str] = Field(default_factory=list)
    left_out: dict[str, str] = Field(default_factory=dict)
    model_is: str = "the usual model"
    model_remark: str = ""

    @property
    def by_prediction(self) -> bool:
        """Whether predictions speak for what is named; elsewhere the whole motion named it, against them."""
        against = any(one.confirmed is False for one in self.suspects if one.effect in self.named)
        return self.confirmation is not None and not against

    def is_of(self, effects: Sequence[str]) -> bool:
        """Whether this is the diagnosis of the model with these effects."""
        return set(self.model.effects) == set(effects)


def diagnosis_document(
    names: tuple[str, ...],
    found: Diagnosis,
    expressions: tuple[str, ...] = (),
    left_out: tuple[Prediction, ...] | None = None,
) -> DiagnosisDocument:
    """Make the document of a diagnosis of some sessions.

    `expressions` are the user's own effects; `left_out` are the errors of physics fitted to the other sessions, None
    with one session.
    """
    baseline, confirmation = found.baseline, found.confirmation
    fitted = model_file(baseline.stated(baseline.fit), expressions)
    uses = zip(names, (decay.use for decay in found.decays), strict=False)
    return DiagnosisDocument.of(
        found,
        format=1,
        sessions=names,
        model=ModelSummary.model_validate(fitted),
        error=errors_of(baseline),
        noise_floor=_noise_floor(found),
        modes=[picked(mode, "percent", "channel", "words", frequency_hz="frequency") for mode in found.modes],
        decided=[
            DecidedDocument.of(one)
            for one in (*found.decided, *(() if confirmation is None else confirmation.asked))
        ],
        walk=plain(picked(found.walk, "evidence", "stiffness", "damping", "reduced")),
        rivals=found.suspects[0].rivals if found.named else (),
        confirmed=[] if confirmation is None else [n for n in found.named if n in confirmation.names],
        confirmation=None if confirmation is None else confirmation_document(confirmation, names),
        suspects=[_suspect(suspect, found, expressions) for suspect in in_order(found)],
        error_with_named=found.error_with_named,
        held_out=None
        if left_out is None
        else [HeldOutDocument.of(one, session=name) for name, one in zip(names, left_out, strict=True)],
        hypotheses=[
            HypothesisDocument.of(one, odds=chance)
            for one, chance in zip(found.hypotheses, odds(found.hypotheses).tolist(), strict=True)
        ],
        next_release=next_release_document(found.next_release),
        fitted=fitted,
        final=model_file(baseline.stated(found.final), expressions) if found.named else None,
        used=[UsedDocument.of(use, session=name) for name, use in uses if use is not None],
        of_sessions=[ReleaseValueDocument.of(one, session=names[one.index]) for one in found.of_releases],
    )


def in_order(found: Diagnosis) -> list[Suspect]:
    """Sort the suspects as every view shows them: the named ones, their rivals, then the others by their residual.

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
    """Make the document of a diagnosis for sessions that hold too little to fit anything."""
    return DiagnosisDocument.model_validate(
        {
            "format": 1,
            "sessions": names,
            "model": {"effects": model.names, "equation": model.equation, "parameters": {}},
            "error": {},
            "verdict": "not_enough_data",
            "explanation": reason,
            "next_experiment": MORE_DATA,
            **dict.fromkeys(("named", "rivals", "suspects", "findings"), ()),
            **dict.fromkeys(("noise_floor", "error_with_named", "shape", "held_out", "fitted")),
        }
    )


def read_diagnosis(session: Session) -> DiagnosisDocument | None:
    """Return the diagnosis that a session keeps, None when it keeps none.

    Raises UsageProblem when it was altered or another version wrote it.
    """
    return read_document(session, NAME, DiagnosisDocument, "diagnose again")


def _noise_floor(found: Diagnosis) -> dict[str, Any]:
    baseline = found.baseline
    unit = baseline.fit.windows[0].unit
    units = {"displacement": unit, "velocity": f"{unit}/s", "acceleration": f"{unit}/s^2"}
    channels = {
        name: picked(noise, "std", "uncertainty", "source") | {"unit": units[name]}
        for name, noise in baseline.floors[0].channels.items()
    }
    harmonics = picked(found.harmonics, "ratio", "p_value", "against")
    known = {"chi2_std": baseline.spread, "sure": baseline.floor_is_sure}
    return plain(known | {"channels": channels, "harmonics": harmonics})


def _suspect(suspect: Suspect, found: Diagnosis, expressions: tuple[str, ...]) -> SuspectDocument:
    confirmation, name = found.confirmation, suspect.effect.name
    asked = confirmation is not None and confirmation.has_law(name)
    return SuspectDocument.of(
        suspect,
        model=model_file(suspect.stated, expressions) if name in suspect.fit.model else None,
        confirmed=suspect.confirmed is not None if asked else None,
    )


def next_release_document(chosen: NextRelease | None) -> dict[str, Any] | None:
    """Write down a chosen release, with the evidence expected of it (nats) and its scatter; None where none was chosen."""
    if chosen is None:
        return None
    best = chosen.best
    told: dict[str, Any] = picked(chosen, "between", "unit", "tells_more", "words")
    told |= picked(best.experiment, "amplitude", "push", "longer", "faster", "rested")
    told |= picked(best, "nats", "scatter")
    return plain(told)
