"""Sessions that a worker has opened: the prepared release and the frames of each are kept while the process lives."""

from dataclasses import dataclass, replace
from pathlib import Path

from daq.session import Session
from station.exits import UsageProblem
from station.operations.refining import Refinement, open_refinement
from station.results.diagnosis_document import DiagnosisDocument, read_diagnosis
from station.results.ladder import read_ladder
from station.settings import Settings
from station.story.preparation import options_for
from station.workbench.frame_store import FrameStore

MOST_OPEN = 8


@dataclass(frozen=True, eq=False)
class Opened:
    """A session whose release is prepared, kept while the process lives; `stamp` changes when the session does."""

    stamp: tuple[int, ...]
    refinement: Refinement
    store: FrameStore


_opened: dict[Path, Opened] = {}


def open_session(settings: Settings, folder: Path) -> Opened:
    """Return a session with its prepared release and its frames, as its results stand."""
    session = Session.open(folder)
    raw = (folder / "raw.log").stat()
    ladder = read_ladder(session)
    described = (folder / "session.json").stat()  # a mass that was given later changes the forces
    stamp = (
        raw.st_mtime_ns,
        raw.st_size,
        described.st_mtime_ns,
        hash(ladder.gain_percent if ladder else None),
    )
    known = _opened.get(folder)
    if known is None or known.stamp != stamp:
        refinement = open_refinement(session, settings)
        known = Opened(stamp, refinement, FrameStore(options_for(session, settings).mass))
        while len(_opened) >= MOST_OPEN:
            _opened.pop(next(iter(_opened)))
        _opened[folder] = known
    if ladder is None:
        return known
    return replace(known, refinement=replace(known.refinement, ladder=ladder, session=session))


def kept_diagnosis(session: Session) -> DiagnosisDocument | None:
    """Return the diagnosis that a session keeps; one that cannot be read counts as none: the page offers a new one."""
    try:
        return read_diagnosis(session)
    except UsageProblem:
        return None
