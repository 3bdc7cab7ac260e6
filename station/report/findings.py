"""The contents of a report: all results of a session, and why the others are left out."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from daq.errors import StationError
from daq.manifest import Manifest
from daq.quality import Verdict
from daq.recording import Recording
from daq.session import Session
from identify.errors import NotIdentifiable
from station.exits import Problem, UsageProblem
from station.operations.current_model import model_of_step
from station.operations.diagnosing import compare_session
from station.operations.identifying import identify_session
from station.operations.refining import open_refinement
from station.operations.session_set import kept_curves
from station.results.diagnosis_document import DiagnosisDocument, read_diagnosis
from station.results.diagnosis_pictures import NamedCurves, NamedMaps, kept_force_maps
from station.results.ladder import LADDER, KeptLadder
from station.results.sessions import doubt
from station.settings import Settings
from station.story.engineering_values import Weighing
from station.story.pipeline import Compared, Identification, Progress, compare, silent
from station.story.preparation import length_unit, weighing_of


@dataclass(eq=False)
class Findings:
    """All that is known of a session; what is None was left out, and `left_out` says why under its name.

    `weighing` puts the mass into forces and strengths. `doubt` says how the session's files are not as they were written,
    "" where they are. `compared` is the current model with the record, `first` the model that its `ladder` began with,
    where that is another.
    """

    session: Session
    recording: Recording
    weighing: Weighing
    manifest: Manifest | None = None
    doubt: str = ""
    identification: Identification | None = None
    compared: Compared | None = None
    first: Compared | None = None
    diagnosis: DiagnosisDocument | None = None
    maps: NamedMaps = ()
    curves: NamedCurves | None = None
    ladder: KeptLadder | None = None
    left_out: dict[str, str] = field(default_factory=dict)

    @property
    def verdict(self) -> Verdict | None:
        """The verdict on the recording; None where the files are in doubt."""
        return None if self.doubt or self.manifest is None else self.manifest.verdict


def gather(session: Session, settings: Settings, progress: Progress) -> Findings:
    """Collect all results of a session; identifies and compares.

    Raises DataLost when the session holds no sample; what else cannot be done is left out and says why.
    """
    recording = session.recording()
    found = Findings(session, recording, weighing_of(session, settings, length_unit(recording)))
    with _or_say_why(found, "identification", NotIdentifiable):
        found.identification, _ = identify_session(session, settings, progress)
    with _or_say_why(found, "comparison", Problem, NotIdentifiable):
        progress("comparing the current model")
        found.compared, _ = compare_session(session, settings, tell=silent)
    with _or_say_why(found, "suspects", UsageProblem):
        found.diagnosis = read_diagnosis(session)
    _say_what_was_refused(found)
    _take_model(found, settings)
    with _or_say_why(found, "checksums", StationError):
        found.manifest = session.manifest()  # last, as it knows the results that were just written
    found.doubt = doubt(session.folder)
    return found


@contextmanager
def _or_say_why(found: Findings, name: str, *refusals: type[Exception]) -> Iterator[None]:
    """Leave a part of the report out where it cannot be had, with the reason."""
    try:
        yield
    except refusals as refusal:
        found.left_out[name] = str(refusal)


def _say_what_was_refused(found: Findings) -> None:
    result, left_out = found.identification, found.left_out
    if result is None:
        left_out["alignment"] = left_out["identification"]
    else:
        alone = {"alignment": "there is one channel only"} if result.alignment is None else {}
        left_out |= alone | {name: why for name, why in result.refusals.items() if name != "adequacy"}


def _take_model(found: Findings, settings: Settings) -> None:
    """Take the ladder with the model that it began with, and what the pictures of a diagnosis are drawn from."""
    session, document, left_out = found.session, found.diagnosis, found.left_out
    refined = (session.results / LADDER).is_file()
    if document is None:
        left_out.setdefault("suspects", "no diagnosis was made of this session; `station diagnose` makes one")
    if not refined:
        left_out["ladder"] = "the model was not refined in this session; `station refine` does that"
    if document is None and not refined:
        return
    with _or_say_why(found, "ladder" if refined else "force_maps", NotIdentifiable, UsageProblem):
        refinement = open_refinement(session, settings)
        ladder = refinement.ladder
        if refined:
            found.ladder = ladder
            if ladder.present > 0 and found.compared is not None:
                first = model_of_step(ladder.steps[0], refinement.library)
                found.first = compare(session.folder.name, refinement.prepared, first)
        if document is not None:
            with _or_say_why(found, "force_maps", UsageProblem):  # an effect of a file that is not at hand
                found.maps = kept_force_maps(document, refinement.prepared, refinement.library)
                found.curves = kept_curves(refinement, document, settings)
