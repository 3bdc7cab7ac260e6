"""Sessions that a worker has opened: each model of one is fitted and drawn once, however often it is looked at."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

from daq.errors import DataLost
from daq.manifest import known_manifest
from daq.session import Session
from daq.session_reading import INFO, RAW
from identify.fitting.baseline import fit_baseline
from identify.fitting.fit import Fit
from station.exits import UsageProblem
from station.operations.refining import Refinement, open_refinement, step_again
from station.results import diagnosis_document
from station.results.diagnosis_pictures import refitted
from station.results.ladder import LADDER, KeptStep, read_ladder
from station.results.models import ModelFile, known_model
from station.settings import Settings
from station.workbench.frames import Ground, frame_id, frame_of, ground_of
from station.workbench.view_models import Drawing

MOST_OPEN = 8
MOST_KEPT = 80


@dataclass(eq=False)
class Opened:
    """A session with its prepared release and its ladder, as it was `begun` and as it is kept now.

    `stamp` changes when the session does. `drawn` are the frames and fits of models, by the frame's name, and `ground` is
    settled by the first of them. `diagnoses` are those that were kept since, by the effects of the model asked about.
    """

    stamp: tuple[object, ...]
    begun: Refinement
    refinement: Refinement
    ground: Ground | None = None
    drawn: dict[str, tuple[Drawing, Fit]] = field(default_factory=dict)
    diagnoses: dict[tuple[str, ...], diagnosis_document.DiagnosisDocument] = field(default_factory=dict)

    def draw(self, model: ModelFile, fitted: Callable[[], Fit]) -> str:
        """Draw a model unless it was drawn before, and return the name of its frame."""
        name = frame_id(model)
        if name not in self.drawn:
            found = fitted()
            if self.ground is None:
                self.ground = ground_of(self.refinement.prepared, found)
            while len(self.drawn) >= MOST_KEPT:
                del self.drawn[next(iter(self.drawn))]
            self.drawn[name] = frame_of(self.ground, found), found
        return name

    def draw_step(self, step: KeptStep) -> str:
        """Draw a step of the ladder: fitted to the whole release at once, from its own values."""
        return self.draw(step.model, lambda: fit_of(self.refinement, step))

    def draw_suspect(self, model: ModelFile) -> str:
        """Draw a suspect's model, fitted to the whole release."""
        base, refinement = self.present_fit(), self.refinement
        return self.draw(model, lambda: refitted(model, base, refinement.prepared, refinement.library)[1])

    def present_fit(self) -> Fit:
        """Fit the present model to the whole release."""
        return self.drawn[self.draw_step(self.refinement.ladder.top)][1]


_opened: dict[Path, Opened] = {}


def open_session(settings: Settings, folder: Path) -> Opened:
    """Open a session as its results stand; a release that was prepared before is prepared."""
    session = Session.open(folder)
    ladder = read_ladder(session)
    if not (folder / RAW).is_file():
        raise _without_raw(session, "is missing")
    raw, described = (folder / RAW).stat(), (folder / INFO).stat()  # a mass changes the forces
    stamp = (raw.st_mtime_ns, raw.st_size, described.st_mtime_ns)
    known = _opened.get(folder)
    if known is None or known.stamp != stamp:
        while len(_opened) >= MOST_OPEN:
            del _opened[next(iter(_opened))]
        try:
            begun = open_refinement(session, settings)
        except DataLost:
            manifest = known_manifest(folder)
            if manifest is None or manifest.files[RAW].size <= raw.st_size:
                raise
            raise _without_raw(session, "is shorter than when it was written") from None
        known = _opened[folder] = Opened(stamp, begun, begun)
    known.refinement = known.begun if ladder is None else replace(known.begun, ladder=ladder, session=session)
    return known


def _without_raw(session: Session, how: str) -> UsageProblem:
    """Say how the raw log of a session was damaged, and what to do."""
    source = session.source_file
    todo = "put it back from a copy, or record again"
    if source is not None and source.is_file():
        todo = f"import {source.parent.name}/{source.name} in the folder of the session again"
    return UsageProblem(f"{RAW}, which holds the samples of {session.folder.name}, {how}: {todo}")


def fit_of(refinement: Refinement, step: KeptStep) -> Fit:
    """Fit a kept step to the whole release, from its values; a short release was fitted whole by the ladder."""
    found = step_again(refinement, step).fit
    if [len(window) for window in found.windows] == [len(refinement.prepared.window)]:
        return found
    known = known_model(step.model, "the ladder", refinement.library)
    alone = {name: value for name, value in step.nuisances.items() if "[" not in name}
    start = known.start((refinement.prepared,)) or {}
    return fit_baseline((refinement.prepared,), known.model, start | alone).fit


def kept_diagnosis(session: Session) -> diagnosis_document.DiagnosisDocument | None:
    """Read the diagnosis that a session keeps; one that cannot be read counts as none: the page offers a new one."""
    try:
        return diagnosis_document.read_diagnosis(session)
    except UsageProblem:
        return None


def results_stamp(folder: Path) -> tuple[int, ...]:
    """Read a stamp that changes when a command, or another tab, has written results."""
    files = [folder / "results" / name for name in (LADDER, diagnosis_document.NAME)]
    return tuple(file.stat().st_mtime_ns if file.is_file() else 0 for file in files)
