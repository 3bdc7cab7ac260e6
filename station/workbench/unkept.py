"""Trying a step of the ladder without keeping it: what Add would do, for a preview."""

from dataclasses import replace

from station.operations.refining import Refinement, tried
from station.workbench import view_models
from station.workbench.frame_store import FrameStore, fit_of
from station.workbench.frames import frame_id
from station.workbench.statements import with_effect

MEASURED_CURVE = "measured_curve"
"""What is added where nothing that has a name fits, see `station refine --add`."""


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
