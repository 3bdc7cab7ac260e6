"""Sessions that were diagnosed together with one, and the curves of them all with the laws of its diagnosis."""

from pathlib import Path

from daq.errors import StationError
from daq.session import Session
from identify.errors import NotIdentifiable
from identify.preprocessing.prepared_decay import PreparedDecay
from station.exits import Problem
from station.operations.refining import Refinement
from station.results.diagnosis_document import DiagnosisDocument
from station.results.diagnosis_pictures import NamedCurves, diagnosed_curves
from station.settings import Settings
from station.story.preparation import prepare_session


def kept_curves(
    refinement: Refinement, document: DiagnosisDocument, settings: Settings
) -> NamedCurves | None:
    """Return the curves of a session and of those beside it that were diagnosed together; None where it has none.

    Sessions that are gone, or cannot be read, are left out. Raises UsageProblem when an effect is not in the library.
    """
    session, prepared = refinement.session, refinement.prepared
    found = [(session.folder.name, prepared)]
    for other in diagnosed_beside(session, document):
        decay = prepared_or_none(other, settings)
        if decay is not None and decay.window.channels == prepared.window.channels:
            found.append((other.folder.name, decay))
    names, decays = zip(*found, strict=True)
    return diagnosed_curves(names, decays, document, refinement.library)


def diagnosed_beside(session: Session, document: DiagnosisDocument) -> tuple[Session, ...]:
    """Open the sessions in the same folder that a diagnosis looked at together with this one, those that are still there."""
    place, own = session.folder.parent, session.folder.name
    folders = [place / name for name in document.sessions if name != own]
    opened = (opened_or_none(folder) for folder in folders if folder.parent == place)
    return tuple(one for one in opened if one is not None)


def opened_or_none(folder: Path) -> Session | None:
    """Open a session; None where the folder is gone, or is none."""
    try:
        return Session.open(folder)
    except (StationError, OSError):
        return None


def prepared_or_none(session: Session, settings: Settings) -> PreparedDecay | None:
    """Prepare the release of a session; None where it holds too little or cannot be read."""
    try:
        return prepare_session(session, settings)
    except (StationError, Problem, NotIdentifiable, OSError):
        return None
