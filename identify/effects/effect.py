"""An effect: one physical cause of force, or one fault of a sensor."""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import pi
from typing import Any, Literal

from identify.arrays import Array
from identify.effects.compiled import PARAMETERS

Kind = Literal["physics", "sensor"]


@dataclass(frozen=True)
class Parameter:
    """One number of an effect.

    In `unit`, "m" stands for the unit of the displacement and is replaced by it (rad, V), "reading" for the unit of
    the channel that a sensor's fault sits in. `low` and `high` are what
    physics allows.
    """

    name: str
    unit: str
    meaning: str
    low: float = -float("inf")
    high: float = float("inf")


@dataclass(frozen=True)
class Scales:
    """What the data say about sizes, for starting values: all SI.

    Largest amplitude `amplitude` (m), angular frequency `frequency` (rad/s), free `duration` (s), sampling `rate` (Hz),
    the largest reading of each channel in `peaks`, and in `lines` the strongest lines of each channel's residual:
    (frequency Hz, amplitude, phase rad at the release).
    """

    amplitude: float
    frequency: float
    duration: float
    rate: float
    peaks: dict[str, float]
    lines: dict[str, tuple[tuple[float, float, float], ...]]

    @property
    def speed(self) -> float:
        """Largest speed, m/s."""
        return self.amplitude * self.frequency

    @property
    def line_frequencies(self) -> tuple[float, ...]:
        """The lines of all channels, Hz."""
        return tuple(line[0] for lines in self.lines.values() for line in lines)


def near_harmonic(line: float, scales: Scales) -> bool:
    """Whether a line (Hz) lies so near zero, the motion's frequency or a harmonic that a nonlinear force makes it too."""
    fundamental = scales.frequency / (2.0 * pi)
    order = round(line / fundamental)
    width = max(0.5 / scales.duration, 0.015 * order * fundamental)
    return line * scales.duration < 3.0 or (1 <= order <= 5 and abs(line - order * fundamental) < width)


@dataclass(frozen=True, eq=False)
class Effect:
    """One cause of misfit: a force per unit mass on the left of u'' + ... = 0, or a fault of a sensor.

    The force is proportional to the first parameter, the strength; the others are inner parameters.
    `force`, `friction` and `rates` are compiled functions of (t, u, v, z, p): `friction` is a level >= 0 that
    acts against the velocity, `rates` drives `states` internal states `z`, two at most; `t` counts from the release.
    `shared_parameters` names parameters of other effects that follow the effect's own in `p`.
    `equilibrium_state(u, p)` gives the internal states of a mass that has been held at `u` for long; with
    `fading_memory`, how it came there does not matter and these are its states at the release, otherwise they are
    unknowns of the fit.
    `observe(time, reading, p)` is a sensor's fault: it changes the predicted readings of one channel.
    `starts(scales)` lists starting values of the inner parameters, `sensor_starts(scales, channel)` of all
    parameters of a sensor's fault, of which those `held_at_first` act out of proportion. A fault that `shows_at_rest`
    is looked for there too; `seems_lag(start, scales)` is by how much it makes its channel seem early (s).
    `variants` are alternatives (inner values that are held, or the channel at fault) that are tried each and of
    which the best counts. `plausible(values, scales)` is False where another effect is the better name for the same
    force. `nonsmooth` forces want a finer step.
    """

    name: str
    title: str
    kind: Kind
    equation: str
    parameters: tuple[Parameter, ...]
    symptom: str
    confirming_test: str
    force: Any = None
    friction: Any = None
    rates: Any = None
    equilibrium_state: Callable[[float, Array], tuple[float, float]] | None = None
    observe: Callable[[Array, Array, Array], Array] | None = None
    states: int = 0
    fading_memory: bool = True
    held_at_first: tuple[str, ...] = ()
    shows_at_rest: bool = False
    seems_lag: Callable[[tuple[float, ...], Scales], float] | None = None
    shared_parameters: tuple[str, ...] = ()
    starts: Callable[[Scales], tuple[tuple[float, ...], ...]] = field(default=lambda scales: ((),))
    sensor_starts: Callable[[Scales, str], tuple[tuple[float, ...], ...]] = field(
        default=lambda scales, channel: ((0.0,),)
    )
    variants: tuple[dict[str, float | str], ...] = ({},)
    plausible: Callable[[dict[str, float], Scales], bool] = field(default=lambda values, scales: True)
    confusable_with: tuple[str, ...] = ()
    nonsmooth: bool = False

    def __post_init__(self) -> None:
        if not 1 <= len(self.parameters) + len(self.shared_parameters) <= PARAMETERS:
            raise ValueError(f"effect {self.name}: 1 to {PARAMETERS} parameters, not {len(self.parameters)}")

    @property
    def inner(self) -> tuple[str, ...]:
        """Parameters that the readings do not follow in proportion; they are held while a fit begins."""
        if self.kind == "sensor":
            return self.held_at_first
        return tuple(p.name for p in self.parameters[1:])

    @property
    def strength(self) -> Parameter:
        """The parameter to which the force is proportional."""
        return self.parameters[0]

    def index(self, parameter: str) -> int:
        """Return the place of a parameter by name; KeyError when there is none."""
        for i, candidate in enumerate(self.parameters):
            if candidate.name == parameter:
                return i
        raise KeyError(f"{self.name} has no parameter {parameter}")
