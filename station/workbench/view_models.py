"""What the page shows of a session: plain values, ready to be drawn."""

from dataclasses import dataclass, field

from station.results.diagnosis_document import DiagnosisDocument
from station.results.ladder import KeptLadder

Numbers = list[float | None]


@dataclass(frozen=True)
class Trace:
    """One channel in the unit in which it is shown: measured, the model run freely, what is left, and the noise.

    `fine` is the factor to the unit `fine_unit` of what is left; `sigma` and `left` are in that unit.
    """

    channel: str
    unit: str
    fine_unit: str
    measured: Numbers
    model: Numbers
    left: Numbers
    sigma: float
    fine: float


@dataclass(frozen=True)
class Section:
    """A cut through the phase plane: missing force and its standard error over a position."""

    name: str
    position: Numbers
    force: Numbers
    std: Numbers


@dataclass(frozen=True)
class Plane:
    """The missing force in bins of the phase plane: each (u from, u to, v from, v to, force, std)."""

    bins: list[list[float]]
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
    """A model beside the measurement, in the units in which it is shown; `time` is in s since the release."""

    time: Numbers
    displacement: Numbers
    velocity: Numbers
    force: Numbers
    displacement_unit: str
    velocity_unit: str
    force_unit: str
    traces: tuple[Trace, ...]
    plane: Plane
    cycles: Cycles
    errors: dict[str, float]
    summary: str
    cause: str
    places: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class ForceMap:
    """A force over the cycle: edges of amplitude (0 to 1) and phase (rad), and the force in each bin, None where unknown."""

    amplitude: Numbers
    phase: Numbers
    force: list[Numbers]


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
class View:
    """What the page shows of a session: ladder, comparison of the present model, last diagnosis, equations by effect.

    `curves` come with a diagnosis; None where the record is too short for them.
    """

    ladder: KeptLadder
    picture: Picture
    diagnosis: DiagnosisDocument | None = None
    equations: dict[str, str] = field(default_factory=dict)
    stamp: tuple[int, ...] = ()
    curves: DecayCurves | None = None


@dataclass(frozen=True)
class Thumbnail:
    """A session on offer: amplitude in words, the decay as points for a sparkline (-1 to 1)."""

    amplitude: str
    line: Numbers
    problem: str = ""
