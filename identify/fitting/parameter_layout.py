"""The parameter layout: the unknowns of a model on some releases, their order, and where each is used."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from identify.arrays import Array
from identify.effects.compiled import PARAMETERS
from identify.effects.effect import Parameter
from identify.effects.force_effect import LinearPart
from identify.free_decay import CHANNELS
from identify.model.model import Model, Term
from identify.model.parameter_id import ParameterId, nuisance
from identify.preprocessing.fit_window import FitWindow, release_numbers, windows_by_release

_READING = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}
NOWHERE = -1
OWN_STIFFNESS, OWN_DAMPING = "own_stiffness", "own_damping"
"""Names of what the linear spring and damper of one release are off those of all."""


@dataclass(frozen=True)
class Unknown:
    """One unknown: its effect, unit, bounds, a natural size, and the window it belongs to (-1: shared physics).

    The size is 0 where it is as large as the value itself. `simulated` unknowns change the motion; the others only
    how it is read. One that `deviates` from a shared unknown, at that place, is what that is in one release beyond what it
    is in all; `std` is the standard deviation of its prior, divided by the root of the weight of that. One of a
    `whole_release` belongs to the first of its windows.
    """

    id: ParameterId
    unit: str
    low: float = -np.inf
    high: float = np.inf
    size: float = 0.0
    window: int = NOWHERE
    simulated: bool = True
    deviates: int = NOWHERE
    std: float = np.inf
    whole_release: bool = False

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
class ReleasePlaces:
    """Where the unknowns of one window are: displacement and velocity at its start, internal states, and how it is read.

    `forces` are the parameters of forces that it has of its own. `lag` and `gain` are NOWHERE without a pair of channels.
    `faults` are those of its sensors, each with its unknowns.
    """

    start: tuple[int, int]
    states: tuple[Cell, ...]
    forces: tuple[Cell, ...]
    lag: int
    gain: int
    offsets: dict[str, int]
    faults: tuple[tuple[Term, list[int]], ...]


class ParameterLayout:
    """The unknowns of a model on windows whose motion has an angular `frequency` (rad/s), physics first.

    `forces` are the terms that the simulator calls, a row of its table each: `held` (rows, parameters) has the values
    that are not fitted, `cells` say where unknowns go. `linear` are the places of the built-in forces' strengths, and
    `force_gain` that of the scale of an external force; NOWHERE where there is none. KeyError for a shared parameter that
    no term has.
    """

    def __init__(self, model: Model, windows: Sequence[FitWindow], frequency: float) -> None:
        self.unknowns: list[Unknown] = []
        self._model, self._frequency = model, frequency
        self._unit, self._count = windows[0].unit, len(windows)
        self._of_forces: dict[int, tuple[Cell, ...]] = {}
        self._releases = release_numbers(windows)
        self._amplitude = max(amplitude_of(window, frequency) for window in windows)
        self.forces = tuple(term for term in model.forces if term.force.linear_part is None)
        self.linear = self._physics()
        self.force_gain = NOWHERE
        if any(window.estimates_mass for window in windows):
            self.force_gain = self._add(Unknown(nuisance("force_gain"), "1", 0.2, 5.0, 1e-2))
        self.releases = tuple(self._release(i, window) for i, window in enumerate(windows))
        self.held, self.cells = self._table()
        self._deviations(windows)

    def _add(self, unknown: Unknown) -> int:
        self.unknowns.append(unknown)
        return len(self.unknowns) - 1

    def _physics(self) -> tuple[int, ...]:
        """Add the parameters of all forces; return the places of the built-in ones' strengths."""
        w, linear = self._frequency, [NOWHERE] * 3
        sizes = (w * w, 0.01 * w, 0.01 * w * w * self._amplitude)
        for term in self._model.forces:
            part = term.force.linear_part
            for parameter in (p for p in term.free if not p.of_release):
                unit = in_unit(parameter.unit, self._unit)
                size = _size_of(parameter) if part is None else sizes[part]
                id = term.parameter(parameter.name)
                at = self._add(Unknown(id, unit, parameter.low, parameter.high, size))
                if part is not None:
                    linear[part] = at
        return tuple(linear)

    def _table(self) -> tuple[Array, tuple[Cell, ...]]:
        """Return the held values, (rows, parameters), and the places of own and shared parameters."""
        place = {unknown.name: at for at, unknown in enumerate(self.unknowns)}
        held, cells = np.zeros((len(self.forces), PARAMETERS)), []
        for row, term in enumerate(self.forces):
            for name, value in term.held_values.items():
                held[row, term.effect.index(name)] = value
            for parameter in (p for p in term.free if not p.of_release):
                name = str(term.parameter(parameter.name))
                cells.append(Cell(row, term.effect.index(parameter.name), place[name]))
            for column, shared in enumerate(term.force.shared_parameters, start=len(term.effect.parameters)):
                cells.append(Cell(row, column, place[shared]))
        return held, tuple(cells)

    def _release(self, i: int, window: FitWindow) -> ReleasePlaces:
        """Add the unknowns of one window."""

        def own(name: str, unit: str, size: float, low: float = -np.inf, high: float = np.inf) -> int:
            simulated = name in ("displacement", "velocity")
            id = nuisance(name, i, self._count)
            return self._add(Unknown(id, unit, low, high, size, i, simulated))

        w = self._frequency
        start = (
            own("displacement", self._unit, self._amplitude),
            own("velocity", f"{self._unit}/s", self._amplitude * w),
        )
        states, forces = self._states(i, window), self._own_of_forces(i)
        lag = gain = NOWHERE
        if window.paired:
            lag = own("lag", "s", 1e-2 / w, window.lag - window.lag_reach, window.lag + window.lag_reach)
            size = abs(window.gain)
            gain = own("gain", "1", 1e-2 * size, window.gain - 5.0 * size, window.gain + 5.0 * size)
        offsets = {
            c: own(
                f"{c}_offset",
                in_unit(_READING[c], self._unit),
                1e-2 * self._amplitude * w ** CHANNELS.index(c),
            )
            for c in window.channels
        }
        return ReleasePlaces(start, states, forces, lag, gain, offsets, self._faults(i, window))

    def _deviations(self, windows: Sequence[FitWindow]) -> None:
        """Add the deviations of each release's spring and damper from the shared ones, where these may differ."""
        groups = windows_by_release(windows)
        for number, places in enumerate(groups.values()):
            own = windows[places[0]].own_linear
            if own is None:
                continue
            for part, name, std in (
                (LinearPart.STIFFNESS, OWN_STIFFNESS, own.stiffness),
                (LinearPart.DAMPING, OWN_DAMPING, own.damping),
            ):
                shared = self.linear[part]
                if shared == NOWHERE or not std > 0.0:
                    continue
                id, unit = nuisance(name, number, len(groups)), self.unknowns[shared].unit
                weighed = std / float(np.sqrt(own.weight))
                self._add(
                    Unknown(
                        id, unit, size=std, window=places[0], deviates=shared, std=weighed, whole_release=True
                    )
                )

    def _states(self, i: int, window: FitWindow) -> tuple[Cell, ...]:
        """Add the internal states at the start of a window that the motion before the release does not give."""
        cells = []
        for row, term in enumerate(self.forces):
            effect = term.force
            if effect.rates is None or (effect.fading_memory and window.pre_release is not None):
                continue
            sizes = effect.state_sizes(self._amplitude, self._frequency)
            for j, size in enumerate(sizes[: effect.states]):
                id, most = term.state(j).of_release(i, self._count), effect.largest_state
                cells.append(Cell(row, j, self._add(Unknown(id, "", -most, most, size, i))))
        return tuple(cells)

    def _own_of_forces(self, i: int) -> tuple[Cell, ...]:
        """Add the parameters of forces that the release of a window has of its own, once for all its windows."""
        numbers, count = self._releases
        number, cells = numbers[i], list[Cell]()
        if number in self._of_forces:
            return self._of_forces[number]
        for row, term in enumerate(self.forces):
            for parameter in (p for p in term.free if p.of_release):
                id, unit = term.in_release(parameter, number, count), in_unit(parameter.unit, self._unit)
                low, high, size = parameter.low, parameter.high, _size_of(parameter)
                own = Unknown(id, unit, low, high, size, i, whole_release=True)
                cells.append(Cell(row, term.effect.index(parameter.name), self._add(own)))
        self._of_forces[number] = tuple(cells)
        return self._of_forces[number]

    def _faults(self, i: int, window: FitWindow) -> tuple[tuple[Term, list[int]], ...]:
        """Add the parameters of the sensors' faults that the channels of a window can show."""
        found = []
        for term in self._model.faults:
            if term.fault.corrected_in_every_fit or term.channel not in window.readings:
                continue
            reading = in_unit(_READING[term.channel], self._unit)
            places = [
                self._add(
                    Unknown(
                        term.parameter(parameter.name).of_release(i, self._count),
                        re.sub(r"\((\w+)\)", r"\1", parameter.unit.replace("reading", reading)),
                        parameter.low,
                        parameter.high,
                        _size_of(parameter),
                        i,
                        simulated=False,
                    )
                )
                for parameter in term.effect.parameters
            ]
            found.append((term, places))
        return tuple(found)


def _size_of(parameter: Parameter) -> float:
    """Return the natural size of a parameter: 1 rad for a phase, 0 where the value itself is the size."""
    return 1.0 if parameter.unit == "rad" else 0.0


def amplitude_of(window: FitWindow, w: float) -> float:
    """Return the largest displacement in the readings of a window, for a motion of angular frequency w (rad/s)."""
    channel = window.channels[0]
    values = window.readings[channel][window.used[channel]]
    return float(np.ptp(values)) / 2.0 / w ** CHANNELS.index(channel) if len(values) else 1.0


def in_unit(unit: str, length: str) -> str:
    """Replace the "m" in a unit by the unit of the displacement."""
    return re.sub(r"(?<![^\W\d_])m(?![^\W\d_])", length, unit)
