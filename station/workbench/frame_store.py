"""The frames of a session as a worker keeps them: each model is fitted and run once, however often it is looked at."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from identify.errors import NotIdentifiable
from identify.fitting.baseline import fit_baseline
from identify.fitting.fit import Fit, fit
from identify.preprocessing.prepared_decay import PreparedDecay
from station.exits import UsageProblem
from station.operations.refining import Refinement, step_again, tried
from station.results.diagnosis_document import DiagnosisDocument
from station.results.ladder import KeptLadder, KeptStep
from station.results.models import ModelFile, known_model, starting_values
from station.story.pipeline import Progress
from station.workbench import view_models
from station.workbench.frames import Ground, frame_id, frame_of, ground_of
from station.workbench.statements import with_effect

MOST_KEPT = 80
MEASURED_CURVE = "measured_curve"
"""What is added where nothing that has a name fits, see `station refine --add`."""


@dataclass(eq=False)
class FrameStore:
    """What was drawn of one session; `ground` is settled by the first model that is looked at."""

    mass: float | None
    ground: Ground | None = None
    frames: dict[str, view_models.Frame] = field(default_factory=dict)
    fits: dict[str, Fit] = field(default_factory=dict)

    def put(self, name: str, prepared: PreparedDecay, found: Fit) -> view_models.Frame:
        """Draw a fitted model, unless it was drawn before, and keep it."""
        if name not in self.frames:
            if self.ground is None:
                self.ground = ground_of(prepared, found, self.mass)
            while len(self.frames) >= MOST_KEPT:
                oldest = next(iter(self.frames))
                del self.frames[oldest]
                self.fits.pop(oldest, None)
            self.frames[name] = frame_of(self.ground, found)
            self.fits[name] = found
        return self.frames[name]


def of_step(store: FrameStore, refinement: Refinement, step: KeptStep) -> None:
    """Draw a step of the ladder: fitted to the whole release at once, from its own values."""
    name = frame_id(step.model)
    if name not in store.frames:
        store.put(name, refinement.prepared, fit_of(refinement, step))


def fit_of(refinement: Refinement, step: KeptStep) -> Fit:
    """Fit a kept step to the whole release, from its values; a short release was fitted whole by the ladder."""
    found = step_again(refinement, step).fit
    if [len(window) for window in found.windows] == [len(refinement.prepared.window)]:
        return found
    known = known_model(step.model, "the ladder", refinement.library)
    alone = {name: value for name, value in step.nuisances.items() if "[" not in name}
    start = starting_values(known, (refinement.prepared,)) | alone
    return fit_baseline((refinement.prepared,), known.model, start).fit


def _fit_near(base: Fit, refinement: Refinement, model: ModelFile) -> Fit:
    """Return a suspect's model fitted to the whole release from its values, which are not lost to another minimum."""
    known = known_model(model, "the diagnosis", refinement.library)
    start = starting_values(known, (refinement.prepared,))
    return fit(known.model, base.windows, start, base.frequency, near=True)


def of_ladder(store: FrameStore, refinement: Refinement, ladder: KeptLadder, progress: Progress) -> None:
    """Draw all steps."""
    for number, step in enumerate(ladder.steps):
        progress(f"drawing step {number + 1} of {len(ladder.steps)}")
        of_step(store, refinement, step)


def of_suspects(
    store: FrameStore, refinement: Refinement, document: DiagnosisDocument
) -> Iterator[view_models.Drawn]:
    """Draw the model with each of the first suspects, and yield each as soon as it is drawn."""
    top = refinement.ladder.top
    of_step(store, refinement, top)
    base = store.fits[frame_id(top.model)]
    shown = [suspect for suspect in document.suspects if suspect.model is not None][: view_models.MOST_CARDS]
    for suspect in shown:
        assert suspect.model is not None
        name = frame_id(suspect.model)
        try:
            if name not in store.frames:
                store.put(name, refinement.prepared, _fit_near(base, refinement, suspect.model))
        except (NotIdentifiable, UsageProblem):  # shown without a picture
            continue
        yield view_models.Drawn({name: store.frames[name]}, {suspect.effect: name})


def frame_of_tried(
    store: FrameStore, refinement: Refinement, wanted: str, called: str
) -> tuple[str, view_models.Frame]:
    """Return the frame of the present model with `wanted` added, which is kept nowhere, and the frame's name."""
    step, _ = tried(refinement, wanted)
    name = frame_id(step.model)
    frame = store.put(name, refinement.prepared, fit_of(refinement, step))
    more = "Fitted to this release; Add keeps it."
    error = step.error
    says = with_effect(refinement.ladder, called, error.motion_percent, error.chi2, more)
    return name, replace(frame, says=says)
