"""What the page shows of a session: plain values, ready to be drawn."""

from dataclasses import dataclass, field
from typing import Any

from daq.importing.recipe import Recipe
from station.results.diagnosis_document import DiagnosisDocument
from station.results.ladder import KeptLadder
from station.text.content import Table

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
class Section:
    """A cut through the phase plane: missing force and its standard error over a position."""

    name: str
    position: Numbers
    force: Numbers
    std: Numbers


@dataclass(frozen=True)
class Plane:
    """Cuts through the missing force: against velocity at zero displacement, and against displacement at reversal."""

    middle: Section
    reversal: tuple[Section, Section]


@dataclass(frozen=True)
class Cycles:
    """Errors of the model cycle by cycle: frequency in %, energy in the unit `energy_unit`."""

    time: Numbers
    frequency: Numbers
    frequency_std: Numbers
    energy: Numbers
    energy_std: Numbers
    energy_unit: str


@dataclass(frozen=True, eq=False)
class Picture:
    """Where a model fails, in the units in which it is shown; `time` is in s since the release."""

    time: Numbers
    displacement_unit: str
    velocity_unit: str
    force_unit: str
    plane: Plane
    cycles: Cycles
    errors: dict[str, float]
    words: str
    summary: str
    cause: str
    places: tuple[str, ...]


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


@dataclass(frozen=True)
class AmplitudeLine:
    """Frequency (Hz) and damping ratio (%) against amplitude: of a release with standard errors, or of a model.

    `role` is "measured", or what the model is to the diagnosis: "usual", "named" or "rival".
    """

    name: str
    role: str
    amplitude: Numbers
    frequency: Numbers
    frequency_std: Numbers
    damping: Numbers
    damping_std: Numbers


@dataclass(frozen=True, eq=False)
class DecayCurves:
    """Curves of releases and models over the amplitude in `unit`; what each chart reaches over."""

    unit: str
    lines: tuple[AmplitudeLine, ...]
    frequency_range: tuple[float, float]
    damping_range: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Details:
    """What the tab Curves shows: the comparison of the present model, and the curves of the last diagnosis.

    `curves` come with a diagnosis; None where the record is too short for them.
    """

    picture: Picture
    curves: DecayCurves | None = None


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
class RawTrace:
    """One channel as it was recorded, in `unit`, against the time since the start of the record (s)."""

    channel: str
    unit: str
    time: Numbers
    values: Numbers


@dataclass(frozen=True)
class Identified:
    """What both identifications find: what is said of the lag, tables, and reasons in sentences.

    `judgement` says whose values may be quoted (`quotable`); "" where no model was fitted to the record. `beside` says the
    same of the identified model where the current one is another.
    """

    lag: str
    tables: tuple[Table, ...]
    notes: tuple[str, ...]
    judgement: str = ""
    quotable: bool = False
    beside: str = ""


@dataclass(frozen=True)
class Thumbnail:
    """A session on offer: amplitude in words, the decay as points for a sparkline (-1 to 1)."""

    amplitude: str
    line: Numbers
    problem: str = ""
