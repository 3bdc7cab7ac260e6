"""What forces and sensors' faults have in common: an effect has a name, parameters, and a way to show."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from math import isfinite, pi, sqrt
from typing import ClassVar, Literal

Kind = Literal["physics", "sensor"]

Starts = tuple[tuple[float, ...], ...]
"""Starting values of some parameters, one tuple for each place from which a fit may begin."""


@dataclass(frozen=True)
class Parameter:
    """One number of an effect.

    In `unit`, "m" stands for the unit of the displacement and is replaced by it (rad, V), "reading" for the unit of
    the channel that a sensor's fault sits in. `low` and `high` are what physics allows. A force's `of_release` has a
    value of its own in each release.
    """

    name: str
    unit: str
    meaning: str
    low: float = -float("inf")
    high: float = float("inf")
    of_release: bool = False


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


def shares_of(size: Literal["amplitude", "speed", "duration"], *shares: float) -> Callable[[Scales], Starts]:
    """Return a function that lists starting values of one parameter: shares of a size in the data."""
    return lambda scales: tuple((share * getattr(scales, size),) for share in shares)


def near_harmonic(line: float, scales: Scales) -> bool:
    """Check whether a line (Hz) lies so near zero or a harmonic of the motion that a nonlinear force may make it."""
    fundamental = scales.frequency / (2.0 * pi)
    order = round(line / fundamental)
    width = max(0.5 / scales.duration, 0.015 * order * fundamental)
    return line * scales.duration < 3.0 or (1 <= order <= 5 and abs(line - order * fundamental) < width)


@dataclass(frozen=True, eq=False, kw_only=True)
class Effect(ABC):
    """One cause of misfit: a force (`ForceEffect`), or a fault of a sensor (`SensorFault`).

    `variants` are alternatives (inner values that are held, or the channel at fault) that are tried each and of
    which the best counts. `plausible(values, scales)` is False where its values make it the same force as another effect.
    `units` are the units of displacement for which the effect has a meaning, () for all. A `line` has a
    frequency and a phase that are free: chance offers it every peak of a periodogram. Of effects that a record does not
    distinguish the one of less `rarity` on benches, its own inner parameters counted in, leads. An effect `of_time` drifts
    with the clock. An effect that `shows_detection_limit` is quoted, with the strength that would
    have been seen, where nothing is missing.
    """

    kind: ClassVar[Kind]
    name: str
    title: str
    equation: str
    parameters: tuple[Parameter, ...]
    symptom: str
    confirming_test: str
    variants: tuple[dict[str, float | str], ...] = ({},)
    plausible: Callable[[dict[str, float], Scales], bool] = field(default=lambda values, scales: True)
    confusable_with: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    line: bool = False
    rarity: int = 0
    of_time: bool = False
    shows_detection_limit: bool = False

    @property
    def inner(self) -> tuple[str, ...]:
        """Parameters that the readings do not follow in proportion; they are held while a fit begins."""
        return tuple(p.name for p in self.parameters[1:])

    @property
    def one_sided(self) -> bool:
        """Whether the readings can be changed in one direction only, so that chance gains nothing in half its draws."""
        return isfinite(self.strength.low)

    @abstractmethod
    def starting_values(self, scales: Scales, channel: str) -> Starts:
        """Return starting values of a force's inner parameters, or of all of a fault, less those that a variant holds.

        There are none where the channel is absent.
        """

    def close_starting_values(self, scales: Scales, channel: str) -> Starts:
        """Return starting values over all that a fit may reach, so close that no place between them looks very different."""
        return with_midpoints(self.starting_values(scales, channel))

    @property
    def strength(self) -> Parameter:
        """The first parameter: a force is proportional to it."""
        return self.parameters[0]

    def index(self, parameter: str) -> int:
        """Return the place of a parameter by name; ValueError when there is none."""
        return [p.name for p in self.parameters].index(parameter)

    def has_meaning_for(self, unit: str) -> bool:
        """Check whether the effect can act on displacements in a unit."""
        return not self.units or unit in self.units


def with_midpoints(starts: Starts) -> Starts:
    """Add a place between each two neighbouring ones."""
    between = (tuple(map(_between, a, b)) for a, b in pairwise(starts))
    return starts[:1] + tuple(place for pair in zip(between, starts[1:], strict=True) for place in pair)


def _between(a: float, b: float) -> float:
    return sqrt(a * b) if a * b > 0.0 else 0.5 * (a + b)
