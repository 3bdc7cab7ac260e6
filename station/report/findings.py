"""What a report is made of: all that is known of a session, and why the rest is left out."""

from dataclasses import dataclass, field

from daq.errors import StationError
from daq.manifest import Manifest
from daq.recording import Recording
from daq.session import Session
from identify.errors import NotIdentifiable
from station.exits import Problem, UsageProblem
from station.operations.comparing import compare_session, compared_with
from station.operations.current_model import model_of_step
from station.operations.diagnosing import diagnose_sessions, keep
from station.operations.identifying import identify_session, kept_options
from station.operations.record_floor import prepare_with_floor
from station.operations.refining import Refinement, open_refinement
from station.operations.session_curves import kept_curves
from station.operations.session_set import SessionSet
from station.results import diagnosis_document
from station.results.curves import NamedCurves
from station.results.diagnosis_document import DiagnosisDocument, read_diagnosis
from station.results.diagnosis_fits import DiagnosisFits, refitted
from station.results.identification_document import IdentificationDocument
from station.results.ladder import LADDER, KeptLadder
from station.settings import Settings
from station.story.compared import Compared
from station.story.identification import Identification
from station.story.pipeline import Progress
from station.story.preparation import Options


@dataclass(eq=False)
class Findings:
    """All that is known of a session; what is None was left out, and `left_out` says why under its name.

    `compared` is the current model with the record, `first` the model that its `ladder` began with, where that is another.
    """

    session: Session
    recording: Recording
    options: Options
    manifest: Manifest | None = None
    identification: Identification | None = None
    document: IdentificationDocument | None = None
    compared: Compared | None = None
    first: Compared | None = None
    diagnosis: DiagnosisDocument | None = None
    fits: DiagnosisFits | None = None
    curves: NamedCurves | None = None
    ladder: KeptLadder | None = None
    left_out: dict[str, str] = field(default_factory=dict)


def gather(
    session: Session, settings: Settings, mass: float | None, *, diagnose: bool, progress: Progress
) -> Findings:
    """Return all that is known of a session; identifies and compares, and diagnoses on request.

    `mass` (kg) replaces the session's. Raises DataLost when the session holds no sample; what else cannot be done is
    left out and says why.
    """
    found = Findings(session, session.recording(), kept_options(session, settings, mass))
    _identify(found)
    _compare(found, settings, mass)
    if diagnose:
        _diagnose(found, settings, progress)
    refinement = _refinement(found, settings)
    _read_diagnosis(found, refinement, settings)
    if refinement is not None and (session.results / LADDER).is_file():
        _first(found, refinement, settings)
    try:
        found.manifest = session.manifest()  # last, as it knows the results that were just written
    except StationError as error:
        found.left_out["checksums"] = str(error)
    return found


def _identify(found: Findings) -> None:
    try:
        found.identification, found.document = identify_session(found.session, found.options)
    except NotIdentifiable as refusal:
        found.left_out["identification"] = str(refusal)


def _compare(found: Findings, settings: Settings, mass: float | None) -> None:
    try:
        found.compared, _ = compare_session(found.session, settings, mass=mass)
    except (Problem, NotIdentifiable) as refusal:
        found.left_out["comparison"] = str(refusal)


def _diagnose(found: Findings, settings: Settings, progress: Progress) -> None:
    try:
        sessions = SessionSet((found.session,), (prepare_with_floor(found.session, settings),))
        _, document = diagnose_sessions(sessions, progress=progress)
        keep(sessions, document)
    except NotIdentifiable as refusal:
        found.left_out["suspects"] = str(refusal)


def _refinement(found: Findings, settings: Settings) -> Refinement | None:
    """Open the model that the session keeps; None where it keeps nothing that can be read."""
    results, left_out = found.session.results, found.left_out
    kept = [(results / name).is_file() for name in (diagnosis_document.NAME, LADDER)]
    if not kept[0]:
        left_out.setdefault("suspects", "no diagnosis was made of this session; `station diagnose` makes one")
    if not kept[1]:
        left_out["ladder"] = "the model was not refined in this session; `station refine` does that"
    if not any(kept):
        return None
    try:
        return open_refinement(found.session, settings)
    except (NotIdentifiable, UsageProblem) as refusal:
        for name, there in zip(("force_maps", "ladder"), kept, strict=True):
            if there:
                left_out[name] = str(refusal)
        return None


def _read_diagnosis(found: Findings, refinement: Refinement | None, settings: Settings) -> None:
    try:
        found.diagnosis = read_diagnosis(found.session)
    except UsageProblem as problem:
        found.left_out["suspects"] = str(problem)
    if found.diagnosis is None or refinement is None:
        return
    prepared, library = refinement.prepared, refinement.library
    try:
        found.fits = refitted(found.diagnosis, prepared, library)
        found.curves = kept_curves(found.session, prepared, found.diagnosis, library, settings)
    except UsageProblem as problem:  # an effect of a file that is not at hand
        found.left_out["force_maps"] = str(problem)


def _first(found: Findings, refinement: Refinement, settings: Settings) -> None:
    """Take the ladder, and compare the model that it began with."""
    ladder = found.ladder = refinement.ladder
    if ladder.present > 0 and found.compared is not None:
        first = model_of_step(ladder.steps[0], refinement.library)
        mass = found.options.mass
        found.first = compared_with(found.session, settings, first, refinement.prepared, mass)
