"""The curves of a session: with the laws of the diagnosis that it keeps, and the sessions that were diagnosed with it."""

from daq.errors import StationError
from daq.session import Session
from identify.effects.effect import Effect
from identify.errors import NotIdentifiable
from identify.preprocessing.prepared_decay import PreparedDecay
from station.exits import Problem
from station.results.curves import NamedCurves, diagnosed_curves
from station.results.diagnosis_document import DiagnosisDocument
from station.settings import Settings
from station.story.preparation import prepare_session


def kept_curves(
    session: Session,
    prepared: PreparedDecay,
    document: DiagnosisDocument,
    library: tuple[Effect, ...],
    settings: Settings,
) -> NamedCurves | None:
    """Return the curves of a session and of those beside it that were diagnosed together; None where it has none.

    Sessions that are gone, or cannot be read, are left out. Raises UsageProblem when an effect is not in the library.
    """
    names, decays = [session.folder.name], [prepared]
    for name in document.sessions:
        if name == session.folder.name:
            continue
        other = _beside(session, name, settings)
        if other is not None and other.window.channels == prepared.window.channels:
            names.append(name)
            decays.append(other)
    return diagnosed_curves(tuple(names), tuple(decays), document, library)


def _beside(session: Session, name: str, settings: Settings) -> PreparedDecay | None:
    folder = session.folder.parent / name
    if folder.parent != session.folder.parent or not folder.is_dir():
        return None
    try:
        return prepare_session(Session.open(folder), settings)
    except (StationError, Problem, NotIdentifiable, OSError):
        return None
