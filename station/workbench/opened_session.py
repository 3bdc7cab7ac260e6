"""Sessions that a worker has opened: each model of one is fitted and drawn once, however often it is looked at."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

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
from station.workbench.frames import frame_id, frame_of, stage_of
from station.workbench.view_models import Drawing, Drawn

MOST_OPEN = 8
MOST_KEPT = 80


@dataclass(eq=False)
class Opened:
    """A session with its prepared release and its ladder, as it was `begun` and as it is kept now.

    `drawn` are the frames and fits of models, by the frame's name, and `stage` is settled by the first of them. `previews`
    are what came of effects that were tried, by the name of the model's frame and what was wanted.
    """

    begun: Refinement
    refinement: Refinement
    stage: Drawing = field(default_factory=dict)
    drawn: dict[str, tuple[Drawing, Fit]] = field(default_factory=dict)
    previews: dict[tuple[str, str], Drawn] = field(default_factory=dict)

    def draw(self, model: ModelFile, fitted: Callable[[], Fit]) -> str:
        """Draw a model unless it was drawn before, and return the name of its frame."""
        name = frame_id(model)
        if name not in self.drawn:
            found = fitted()
            prepared = self.refinement.prepared
            self.stage = self.stage or stage_of(prepared, found)
            while len(self.drawn) >= MOST_KEPT:
                del self.drawn[next(iter(self.drawn))]
            self.drawn[name] = frame_of(prepared, found), found
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


@lru_cache(maxsize=MOST_OPEN)
def _begun(settings: Settings, folder: Path, stamp: tuple[int, ...]) -> Opened:
    """Open a session and begin its ladder, once for each `stamp`, which changes when the session does."""
    begun = open_refinement(Session.open(folder), settings)
    return Opened(begun, begun)


def open_session(settings: Settings, folder: Path) -> Opened:
    """Open a session as its results stand; a release that was prepared before is prepared."""
    session = Session.open(folder)
    ladder = read_ladder(session)
    files = [folder / name for name in (RAW, INFO)]  # a mass changes the forces
    opened = _begun(settings, folder, _stamp(files))
    begun = opened.begun
    opened.refinement = begun if ladder is None else replace(begun, ladder=ladder, session=session)
    return opened


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


def session_stamp(folder: Path) -> tuple[int, ...]:
    """Read a stamp that changes when a command, or another tab, changed the session: its raw data and info come first."""
    names = RAW, INFO, f"results/{LADDER}", f"results/{diagnosis_document.NAME}"
    return _stamp(folder / name for name in names)


def _stamp(files: Iterable[Path]) -> tuple[int, ...]:
    found = [file.stat() if file.is_file() else None for file in files]
    return tuple(0 if one is None else one.st_mtime_ns ^ one.st_size for one in found)
