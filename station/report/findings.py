"""What a report is made of: all that is known of a session, and why the rest is left out."""

from dataclasses import dataclass, field

from daq.errors import StationError
from daq.manifest import Manifest
from daq.recording import Recording
from daq.session import Session
from identify.diagnosis.ladder import Rung
from identify.errors import NotIdentifiable
from identify.fitting.baseline import fit_baseline
from station.exits import Problem, UsageProblem
from station.operations.beginning import beginning
from station.operations.comparing import compare_session
from station.operations.diagnosing import diagnose_sessions, keep
from station.operations.identifying import identify_session, kept_options
from station.operations.record_floor import prepare_with_floor
from station.operations.refining import Refinement, open_refinement, rung_again
from station.operations.session_curves import kept_curves
from station.operations.session_set import SessionSet
from station.results import comparison_document, diagnosis_document
from station.results.curves import NamedCurves
from station.results.diagnosis_document import DiagnosisDocument, read_diagnosis
from station.results.diagnosis_fits import DiagnosisFits, refitted
from station.results.identification_document import IdentificationDocument
from station.results.ladder import LADDER, KeptLadder
from station.results.models import known_model, starting_values
from station.settings import Settings
from station.story.compared import Compared
from station.story.identification import Identification
from station.story.pipeline import Progress, compare, compare_fitted
from station.story.preparation import Options


@dataclass(frozen=True, eq=False)
class FittedLadder:
    """The ladder of a session, the fit of its present rung, and that model compared with the record."""

    ladder: KeptLadder
    top: Rung
    compared: Compared


@dataclass(eq=False)
class Findings:
    """All that is known of a session; what is None was left out, and `left_out` says why under its name."""

    session: Session
    recording: Recording
    options: Options
    manifest: Manifest | None = None
    identification: Identification | None = None
    document: IdentificationDocument | None = None
    compared: Compared | None = None
    diagnosis: DiagnosisDocument | None = None
    fits: DiagnosisFits | None = None
    curves: NamedCurves | None = None
    refined: FittedLadder | None = None
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
    if refinement is not None:
        _refit(found, refinement)
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
    """Compare with the model to begin with; kept in the session only where no comparison is kept yet."""
    session = found.session
    try:
        if (session.results / comparison_document.NAME).is_file():
            prepared = prepare_with_floor(session, settings, mass=mass)
            begun = beginning((session,), (prepared,))
            found.compared = compare(
                session.folder.name, prepared, begun.model, mass=found.options.mass, words=begun.words
            )
        else:
            found.compared, _ = compare_session(session, settings, mass=mass)
    except NotIdentifiable as refusal:
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


def _refit(found: Findings, refinement: Refinement) -> None:
    if not (found.session.results / LADDER).is_file():
        return
    ladder, prepared, name, mass = (
        refinement.ladder, refinement.prepared, found.session.folder.name, found.options.mass
    )  # fmt: skip
    words = "the present model"
    try:
        top = rung_again(refinement, ladder.top)
    except (Problem, NotIdentifiable) as refusal:
        found.left_out["ladder"] = str(refusal)
        return
    if (
        len(top.baseline.decays) > 1
    ):  # fitted in segments, which start each for themselves; compared in one run
        known = known_model(ladder.top.model, "the ladder", refinement.library)
        start = starting_values(known, (prepared,))
        try:
            whole = fit_baseline((prepared,), known.model, start)
            compared = compare_fitted(name, whole, mass=mass, words=words, judged=top.baseline)
        except NotIdentifiable as refusal:
            found.left_out["ladder"] = str(refusal)
            return
    else:
        compared = compare_fitted(name, top.baseline, mass=mass, words=words)
    found.refined = FittedLadder(ladder, top, compared)
