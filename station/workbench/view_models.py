"""The view of a session for the page: plain values, ready to be drawn."""

from dataclasses import dataclass, field
from typing import Any

from station.results.diagnosis_document import DiagnosisDocument
from station.results.ladder import KeptLadder
from station.story.engineering_values import UNKNOWN, Weighing

Numbers = list[float | None]
"""Values to draw, None where nothing is known."""

Drawing = dict[str, Any]
"""What the page's script draws; `frames.stage_of` and `frames.frame_of` say what is in it."""

MOST_CARDS = 8
"""Suspects that have a card, and so a frame."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """Frames by their names; of effects that may be added the name of each one's frame, and what is said of it."""

    frames: dict[str, Drawing] = field(default_factory=dict)
    suspects: dict[str, str] = field(default_factory=dict)
    says: dict[str, Drawing] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class View:
    """What the page shows of a session: ladder, last diagnosis, equations by effect.

    `frames` are those at hand, by the name of `step_frames` (one for each step). `note` is what a task has to say,
    `equation` that of the present model, `weighing` what puts the mass into its strengths; `mystery` says that a simulated
    board hid something.
    """

    ladder: KeptLadder
    diagnosis: DiagnosisDocument | None = None
    equations: dict[str, str] = field(default_factory=dict)
    stamp: tuple[int, ...] = ()
    stage: Drawing = field(default_factory=dict)
    frames: dict[str, Drawing] = field(default_factory=dict)
    step_frames: tuple[str, ...] = ()
    note: str = ""
    equation: str = ""
    weighing: Weighing = UNKNOWN
    mystery: bool = False

    @property
    def about_present(self) -> bool:
        """Whether the diagnosis is about the present model."""
        return self.diagnosis is not None and self.diagnosis.model.effects == list(self.ladder.top.effects)

    @property
    def at_floor(self) -> bool:
        """Whether the present model leaves no more than noise does."""
        return self.ladder.top.at_floor
