"""The parameter layout: which unknowns a model has on some releases, in which order, and where each is used."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from identify.arrays import Array
from identify.effects.compiled import PARAMETERS
from identify.effects.effect import Parameter
from identify.effects.force_effect import LinearPart
from identify.effects.sensor_fault import SensorFault
from identify.model.model import Model, Term
from identify.model.parameter_id import ParameterId, nuisance
from identify.preprocessing.fit_window import FitWindow

_DERIVATIVE = {"displacement": 0, "velocity": 1, "acceleration": 2}
_READING = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}
NOWHERE = -1
OWN_STIFFNESS, OWN_DAMPING = "own_stiffness", "own_damping"
"""Names of what the linear spring and damper of one release are off those of all."""


@dataclass(frozen=True)
class Unknown:
    """One number to be found: whose it is, unit, bounds, a natural size, and the window it belongs to (-1: shared physics).

    The size is 0 where it is as large as the value itself. `simulated` unknowns change the motion; the others only
    how it is read. What `moves` several windows, the pieces of one release, has the first of them as its window. It
    `deviates` from a shared unknown, at that place, by what that is in its release beyond what it is in all.
    """

    id: ParameterId
    unit: str
    low: float
    high: float
    size: float
    window: int
    simulated: bool
    moves: tuple[int, ...] = ()
    deviates: int = NOWHERE

    @cached_property
    def name(self) -> str:
        """The name in documents."""
        return str(self.id)


@dataclass(frozen=True)
class Cell:
    """An unknown and the place, by effect and column, at which the simulator takes it."""

    row: int
    column: int
    unknown: int


@dataclass(frozen=True, eq=False)
class FaultPlaces:
    """A sensor's fault, the channel that it sits in, and its unknowns."""

    fault: SensorFault
    channel: str
    unknowns: list[int]


@dataclass(frozen=True, eq=False)
class ReleasePlaces:
    """Where the unknowns of one window are: displacement and velocity at its start, internal states, and how it is read.

    `lag` and `gain` are NOWHERE without a pair of channels.
    """

    start: tuple[int, int]
    states: tuple[Cell, ...]
    lag: int
    gain: int
    offsets: dict[str, int]
    faults: tuple[FaultPlaces, ...]


@dataclass(frozen=True)
class Deviation:
    """An unknown at place `own` that adds to the shared one at `shared` in some windows, and its standard deviation.

    The latter is that of the prior, divided by the root of its weight.
    """

    own: int
    shared: int
    windows: tuple[int, ...]
    std: float


@dataclass(frozen=True, eq=False)
class ParameterLayout:
    """The unknowns of a model on some releases, physics first.

    `forces` are the terms that the simulator calls, a row of its table each: `held` (rows, parameters) has the values
    that are not fitted, `cells` say where unknowns go. `linear` are the places of the built-in forces' strengths, and
    `force_gain` that of the scale of an external force; NOWHERE where there is none. `deviations` are what single
    releases have of their own beside a shared strength.
    """

    unknowns: tuple[Unknown, ...]
    forces: tuple[Term, ...]
    linear: tuple[int, ...]
    held: Array
    cells: tuple[Cell, ...]
    force_gain: int
    releases: tuple[ReleasePlaces, ...]
    deviations: tuple[Deviation, ...] = ()


def lay_out(model: Model, windows: tuple[FitWindow, ...], frequency: float) -> ParameterLayout:
    """List the unknowns of a model on windows whose motion has an angular `frequency` (rad/s)."""
    amplitude = max(amplitude_of(window, frequency) for window in windows)
    builder = _Builder(model, frequency, amplitude, windows[0].unit, len(windows))
    linear = builder.linear_and_forces()
    force_gain = NOWHERE
    if any(window.estimates_mass for window in windows):
        force_gain = builder.add(nuisance("force_gain"), "1", size=1e-2, low=0.2, high=5.0)
    releases = tuple(builder.release(i, window) for i, window in enumerate(windows))
    cells, deviations = builder.cells(), builder.deviations(linear, windows)
    return ParameterLayout(
        tuple(builder.unknowns), builder.forces, linear, builder.held, cells, force_gain, releases, deviations
    )


def windows_by_release(windows: Sequence[FitWindow]) -> dict[int, tuple[int, ...]]:
    """Return the places of the windows of each release, by its number."""
    found: dict[int, tuple[int, ...]] = {}
    for i, window in enumerate(windows):
        found[window.release] = (*found.get(window.release, ()), i)
    return found


@dataclass(eq=False)
class _Builder:
    """Collects the unknowns in their order; `amplitude` and `frequency` give their natural sizes."""

    model: Model
    frequency: float
    amplitude: float
    unit: str
    count: int
    unknowns: list[Unknown] = field(default_factory=list)

    @cached_property
    def forces(self) -> tuple[Term, ...]:
        return tuple(term for term in self.model.forces if term.force.linear_part is None)

    @cached_property
    def held(self) -> Array:
        table = np.zeros((len(self.forces), PARAMETERS))
        for row, term in zip(table, self.forces, strict=True):
            for name, value in term.held_values.items():
                row[term.effect.index(name)] = value
        return table

    def add(
        self,
        id: ParameterId,
        unit: str,
        *,
        size: float = 0.0,
        low: float = -np.inf,
        high: float = np.inf,
        window: int = NOWHERE,
        simulated: bool = True,
        moves: tuple[int, ...] = (),
        deviates: int = NOWHERE,
    ) -> int:
        self.unknowns.append(Unknown(id, unit, low, high, size, window, simulated, moves, deviates))
        return len(self.unknowns) - 1

    def linear_and_forces(self) -> tuple[int, ...]:
        """Add the parameters of all forces; return the places of the built-in ones' strengths."""
        w, linear = self.frequency, [NOWHERE] * 3
        sizes = (w * w, 0.01 * w, 0.01 * w * w * self.amplitude)
        for term in self.model.forces:
            part = term.force.linear_part
            for parameter in term.free:
                at = self.add(
                    term.parameter(parameter.name),
                    in_unit(parameter.unit, self.unit),
                    size=_size_of(parameter) if part is None else sizes[part],
                    low=parameter.low,
                    high=parameter.high,
                )
                if part is not None:
                    linear[part] = at
        return tuple(linear)

    def cells(self) -> tuple[Cell, ...]:
        """Return where the forces' own and shared parameters go; KeyError for a shared one that no term has."""
        place = {unknown.name: at for at, unknown in enumerate(self.unknowns)}
        cells = []
        for row, term in enumerate(self.forces):
            for parameter in term.free:
                name = str(term.parameter(parameter.name))
                cells.append(Cell(row, term.effect.index(parameter.name), place[name]))
            for column, shared in enumerate(term.force.shared_parameters, start=len(term.effect.parameters)):
                cells.append(Cell(row, column, place[shared]))
        return tuple(cells)

    def release(self, i: int, window: FitWindow) -> ReleasePlaces:
        """Add what one window has of its own."""

        def own(name: str, unit: str, size: float, low: float = -np.inf, high: float = np.inf) -> int:
            simulated = name in ("displacement", "velocity")
            id = nuisance(name, i, self.count)
            return self.add(id, unit, size=size, low=low, high=high, window=i, simulated=simulated)

        w = self.frequency
        start = (
            own("displacement", self.unit, self.amplitude),
            own("velocity", f"{self.unit}/s", self.amplitude * w),
        )
        states = self._states(i, window)
        lag = gain = NOWHERE
        if window.paired:
            lag = own("lag", "s", 1e-2 / w, window.lag - window.lag_reach, window.lag + window.lag_reach)
            gain = own("gain", "1", 1e-2, 0.2, 5.0)
        offsets = {
            c: own(
                f"{c}_offset", in_unit(_READING[c], self.unit), 1e-2 * self.amplitude * w ** _DERIVATIVE[c]
            )
            for c in window.channels
        }
        return ReleasePlaces(start, states, lag, gain, offsets, self._faults(i, window))

    def deviations(self, linear: tuple[int, ...], windows: tuple[FitWindow, ...]) -> tuple[Deviation, ...]:
        """Add by how much spring and damper of each release differ from those of all, where they may."""
        found, groups = [], windows_by_release(windows)
        for number, places in enumerate(groups.values()):
            own = windows[places[0]].own_linear
            if own is None:
                continue
            for part, name, std in (
                (LinearPart.STIFFNESS, OWN_STIFFNESS, own.stiffness),
                (LinearPart.DAMPING, OWN_DAMPING, own.damping),
            ):
                if linear[part] == NOWHERE or not std > 0.0:
                    continue
                unit = self.unknowns[linear[part]].unit
                id = nuisance(name, number, len(groups))
                at = self.add(id, unit, size=std, window=places[0], moves=places, deviates=linear[part])
                found.append(Deviation(at, linear[part], places, std / float(np.sqrt(own.weight))))
        return tuple(found)

    def _states(self, i: int, window: FitWindow) -> tuple[Cell, ...]:
        """Add the internal states at the start of a window that the motion before the release does not give."""
        cells = []
        for row, term in enumerate(self.forces):
            effect = term.force
            if effect.rates is None or (effect.fading_memory and window.pre_release is not None):
                continue
            sizes = effect.state_sizes(self.amplitude, self.frequency)
            for j, size in enumerate(sizes[: effect.states]):
                id, most = term.state(j).of_release(i, self.count), effect.largest_state
                cells.append(Cell(row, j, self.add(id, "", size=size, low=-most, high=most, window=i)))
        return tuple(cells)

    def _faults(self, i: int, window: FitWindow) -> tuple[FaultPlaces, ...]:
        """Add the parameters of the sensors' faults that the channels of a window can show."""
        found = []
        for term in self.model.faults:
            if term.fault.corrected_in_every_fit or term.channel not in window.readings:
                continue
            reading = in_unit(_READING[term.channel], self.unit)
            places = [
                self.add(
                    term.parameter(parameter.name).of_release(i, self.count),
                    parameter.unit.replace("reading", reading),
                    size=_size_of(parameter),
                    low=parameter.low,
                    high=parameter.high,
                    window=i,
                    simulated=False,
                )
                for parameter in term.effect.parameters
            ]
            found.append(FaultPlaces(term.fault, term.channel, places))
        return tuple(found)


def _size_of(parameter: Parameter) -> float:
    """Return the natural size of a parameter: 1 rad for a phase, 0 for what is as large as its value itself."""
    return 1.0 if parameter.unit == "rad" else 0.0


def amplitude_of(window: FitWindow, w: float) -> float:
    """Return the largest displacement that the readings of a window show of a motion of angular frequency w (rad/s)."""
    channel = window.channels[0]
    values = window.readings[channel][window.used[channel]]
    return float(np.ptp(values)) / 2.0 / w ** _DERIVATIVE[channel] if len(values) else 1.0


def in_unit(unit: str, length: str) -> str:
    """Return a unit in which "m" stands for the unit of the displacement, with that unit in its place."""
    if length == "m":
        return unit
    out = []
    for i, letter in enumerate(unit):
        alone = (i == 0 or not unit[i - 1].isalpha()) and (i + 1 == len(unit) or not unit[i + 1].isalpha())
        out.append(length if letter == "m" and alone else letter)
    return "".join(out)
