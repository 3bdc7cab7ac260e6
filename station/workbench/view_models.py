"""What the page shows of a session: plain values, ready to be drawn."""

from dataclasses import dataclass, field
from typing import Any

from daq.importing.recipe import Recipe
from station.results.diagnosis_document import DiagnosisDocument
from station.results.ladder import KeptLadder

Numbers = list[float | None]

MOST_CARDS = 8
"""Suspects that have a card, and so a frame."""


@dataclass(frozen=True)
class AskedColumn:
    """A column of a file: what it is called, its first numbers, and all of it as a line of few."""

    place: str
    numbers: str
    line: Numbers


@dataclass(frozen=True)
class ImportQuestion:
    """What is to be said of a file: a sentence, the recipe that is proposed, and a column for each of its fields."""

    sentence: str
    recipe: Recipe
    columns: tuple[AskedColumn, ...]


@dataclass(frozen=True)
class Campaign:
    """What came of several files: the names of the sessions, and the campaign in 80 columns."""

    sessions: list[str]
    text: str


@dataclass(frozen=True)
class Measured:
    """One channel as it was measured, in `unit`; `sigma` is its noise in `fine_unit`, `fine` the factor between the two."""

    channel: str
    unit: str
    fine_unit: str
    values: Numbers
    sigma: float
    fine: float


@dataclass(frozen=True, eq=False)
class MapAxes:
    """Cells of a map: edges of rows and of columns, and the cells that were visited, row * columns + column."""

    rows: Numbers
    columns: Numbers
    cells: list[int]


@dataclass(frozen=True, eq=False)
class Stage:
    """What stays while models change: the measurement, and the axes and cells of the map, from the release alone.

    `time` is in s since the release. `cycle` has rows of amplitude and columns of phase (rad; 0 at the largest
    displacement, growing with time); `velocity_per_amplitude` is the velocity that goes with one unit of amplitude. `units`
    are those of displacement "u", velocity "v" and force "f".
    """

    time: Numbers
    velocity_per_amplitude: float
    units: dict[str, str]
    traces: tuple[Measured, ...]
    cycle: MapAxes


@dataclass(frozen=True, eq=False)
class Frame:
    """What one model leaves: its readings and the misfit of each channel, and the force that it lacks in each cell.

    Forces and their standard errors are in the stage's unit, None where nothing is known. `says` is what to say of a model
    that is on no step.
    """

    model: tuple[Numbers, ...]
    left: tuple[Numbers, ...]
    cycle: Numbers
    cycle_std: Numbers
    says: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Drawn:
    """Frames by their names, and the names of those of suspects by effect."""

    frames: dict[str, Frame]
    suspects: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class View:
    """What the page shows of a session: ladder, last diagnosis, equations by effect.

    `frames` are those at hand, by the name of `step_frames` (one for each step). `note` is what a task has to say,
    `with_mass` the strengths of the present model with the mass in them, by "effect.parameter", where it is known;
    `mystery` says that a simulated board hid something.
    """

    ladder: KeptLadder
    diagnosis: DiagnosisDocument | None = None
    equations: dict[str, str] = field(default_factory=dict)
    stamp: tuple[int, ...] = ()
    stage: Stage | None = None
    frames: dict[str, Frame] = field(default_factory=dict)
    step_frames: tuple[str, ...] = ()
    note: str = ""
    with_mass: dict[str, str] = field(default_factory=dict)
    mystery: bool = False

    @property
    def about_present(self) -> bool:
        """Whether the diagnosis is about the present model."""
        return self.diagnosis is not None and list(self.diagnosis.model.effects) == list(
            self.ladder.top.effects
        )

    @property
    def at_floor(self) -> bool:
        """Whether the present model leaves no more than noise does."""
        return self.ladder.top.at_floor


@dataclass(frozen=True)
class Sent:
    """A picture that was drawn by a worker, as a data URI."""

    uri: str


@dataclass(frozen=True)
class Thumbnail:
    """A session on offer: amplitude in words, the decay as points for a sparkline (-1 to 1)."""

    amplitude: str
    line: Numbers
    problem: str = ""
