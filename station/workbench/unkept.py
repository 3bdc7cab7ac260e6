"""Trying a step of the ladder without keeping it: what Add would do, for a preview."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

from daq.session import Session
from station.operations.refining import Refinement, add
from station.results.ladder import KeptStep
from station.workbench import view_models
from station.workbench.frame_store import FrameStore, fit_of
from station.workbench.frames import frame_id
from station.workbench.statements import with_effect

MEASURED_CURVE = "measured_curve"
"""What is added where nothing that has a name fits, see `station refine --add`."""


@dataclass(frozen=True)
class Unkept:
    """Stands for a session while a step is tried: what would be written into it goes nowhere."""

    folder: Path

    @property
    def results(self) -> Path:
        """The folder of the results."""
        return self.folder / "results"

    def write_results(self, contents: dict[str, str], seen: dict[str, str | None] | None = None) -> None:
        """Write nothing."""


def tried(refinement: Refinement, wanted: str) -> KeptStep:
    """Return the step that adding `wanted` would give; raises what `add` raises."""
    nowhere = cast(Session, Unkept(refinement.session.folder))
    return add(replace(refinement, session=nowhere), wanted).top


def frame_of_tried(
    store: FrameStore, refinement: Refinement, wanted: str, called: str
) -> tuple[str, view_models.Frame]:
    """Return the frame of the present model with `wanted` added, which is kept nowhere, and the frame's name."""
    step = tried(refinement, wanted)
    name = frame_id(step.model)
    frame = store.put(name, refinement.prepared, fit_of(refinement, step.model, step.nuisances))
    more = "Fitted to this release; Add keeps it."
    error = step.error
    says = with_effect(refinement.ladder, called, error.motion_percent, error.chi2, more)
    return name, replace(frame, says=says)
