"""The problem that a fit solves: parameters to predicted readings, in units of the noise."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, Mask
from identify.effects.compiled import PARAMETERS, STATES
from identify.model.measured_path import states_after
from identify.model.model import Model, Term
from identify.model.simulate import Response, make_system, simulate, substeps_for
from identify.preprocessing.fit_window import FitWindow, PreReleaseMotion

LINEAR = {"linear_stiffness": 0, "viscous_damping": 1, "coulomb_friction": 2}
_STEP = 1e-5
_STEP_TRIALS = 4
_STEP_GROWTH = 1e3
_LONGEST_STEP = 1e-2
_JUMP = 0.5
"""Change of a reading by a small step, in units of the noise, from which on a reversal has crossed its sample."""

_READABLE = 3e-3
"""Root mean square change of the readings, in units of the noise, at which a difference is taken."""
_STATE_REACH = 6.0
_PRELUDE_STEPS = 16


@dataclass(frozen=True)
class Unknown:
    """One number to be found: name, unit, bounds, a natural size, and the span it belongs to (-1: shared physics).

    `simulated` unknowns change the motion; the others only how it is read.
    """

    name: str
    unit: str
    low: float
    high: float
    size: float
    window: int
    simulated: bool


class Problem:
    """A model on one or more spans: the physics is shared, each span has nuisance parameters of its own.

    The nuisances are the state at the start of the span, the internal states of effects with memory, and,
    where there are two channels, lag and gain; and an offset of every channel.
    """

    def __init__(self, model: Model, windows: tuple[FitWindow, ...], frequency: float) -> None:
        self.model = model
        self.windows = windows
        self.frequency = frequency
        self.physics = [t for t in model.terms if t.effect.kind == "physics" and t.effect.name not in LINEAR]
        self.system = make_system(tuple(t.effect for t in self.physics))
        self.unknowns: list[Unknown] = []
        self._table = np.zeros((len(self.physics), PARAMETERS))
        self._places: list[tuple[str, int, int]] = []
        self._sensors: list[tuple[int, str, Callable[[Array, Array, Array], Array], list[int]]] = []
        self._lay_out()
        self.low = np.array([u.low for u in self.unknowns])
        self.high = np.array([u.high for u in self.unknowns])
        self.size = np.array([u.size for u in self.unknowns])
        self._steps = np.zeros(len(self.unknowns))
        self._counts = [sum(int(window.used[c].sum()) for c in window.channels) for window in windows]
        self.index = {u.name: i for i, u in enumerate(self.unknowns)}

    def _add(self, *args: object) -> int:
        self.unknowns.append(Unknown(*args))  # type: ignore[arg-type]
        return len(self.unknowns) - 1

    def _lay_out(self) -> None:
        w = self.frequency
        amplitude = max(_amplitude(window, w) for window in self.windows)
        force = 0.01 * w * w * amplitude
        unit = self.windows[0].unit
        self._linear_at = [-1, -1, -1]
        self._linear = np.zeros(3)
        sizes = {"linear_stiffness": w * w, "viscous_damping": 0.01 * w, "coulomb_friction": force}
        row = 0
        self._shared: list[tuple[int, int, str]] = []
        for term in self.model.terms:
            effect = term.effect
            if effect.kind == "sensor":
                continue
            for j, parameter in enumerate(effect.parameters):
                held = term.held.get(parameter.name)
                name = f"{effect.name}.{parameter.name}"
                if effect.name in LINEAR:
                    place = LINEAR[effect.name]
                    self._linear_at[place] = self._add(
                        name,
                        _unit(parameter.unit, unit),
                        parameter.low,
                        parameter.high,
                        sizes[effect.name],
                        -1,
                        True,
                    )
                elif held is not None:
                    self._table[row, j] = float(held)
                else:
                    at = self._add(
                        name, _unit(parameter.unit, unit), parameter.low, parameter.high, 0.0, -1, True
                    )
                    self._places.append((name, row, j))
                    assert at >= 0
            if effect.name not in LINEAR:
                for offset, shared in enumerate(effect.shared_parameters):
                    self._shared.append((row, len(effect.parameters) + offset, shared))
                row += 1
        self._weight = (
            self._add("force_gain", "1", 0.2, 5.0, 1e-2, -1, True)
            if any(s.estimates_mass for s in self.windows)
            else -1
        )
        self._place_at = {name: (r, j) for name, r, j in self._places}
        self._starts: list[tuple[int, int]] = []
        self._states: list[list[tuple[int, int, int]]] = []
        self._lags: list[int] = []
        self._gains: list[int] = []
        self._offsets: list[dict[str, int]] = []
        for i, window in enumerate(self.windows):
            tag = f"[{i}]" if len(self.windows) > 1 else ""
            big = amplitude
            self._starts.append(
                (
                    self._add(f"displacement{tag}", unit, -np.inf, np.inf, big, i, True),
                    self._add(f"velocity{tag}", f"{unit}/s", -np.inf, np.inf, big * w, i, True),
                )
            )
            states = []
            for r, term in enumerate(self.physics):
                if term.effect.rates is not None and not (
                    term.effect.fading_memory and window.pre_release is not None
                ):
                    for j in range(term.effect.states):
                        at = self._add(
                            f"{term.effect.name}.state{j}{tag}",
                            "",
                            -np.inf,
                            np.inf,
                            big * (w if j else 1.0),
                            i,
                            True,
                        )
                        states.append((at, r, j))
            self._states.append(states)
            if window.paired:
                self._lags.append(
                    self._add(
                        f"lag{tag}",
                        "s",
                        window.lag - window.lag_reach,
                        window.lag + window.lag_reach,
                        1e-2 / w,
                        i,
                        False,
                    )
                )
                self._gains.append(self._add(f"gain{tag}", "1", 0.2, 5.0, 1e-2, i, False))
            else:
                self._lags.append(-1)
                self._gains.append(-1)
            powers = {"displacement": 0, "velocity": 1, "acceleration": 2}
            self._offsets.append(
                {
                    c: self._add(
                        f"{c}_offset{tag}",
                        _unit({0: "m", 1: "m/s", 2: "m/s^2"}[powers[c]], unit),
                        -np.inf,
                        np.inf,
                        1e-2 * amplitude * w ** powers[c],
                        i,
                        False,
                    )
                    for c in window.channels
                }
            )
            for term in self.model.terms:
                if (
                    term.effect.kind != "sensor"
                    or term.effect.observe is None
                    or term.channel not in window.readings
                ):
                    continue
                places = []
                for parameter in term.effect.parameters:
                    reading = _unit({0: "m", 1: "m/s", 2: "m/s^2"}[powers[term.channel]], unit)
                    places.append(
                        self._add(
                            f"{term.effect.name}.{parameter.name}{tag}",
                            parameter.unit.replace("reading", reading),
                            parameter.low,
                            parameter.high,
                            0.0,
                            i,
                            False,
                        )
                    )
                self._sensors.append((i, term.channel, term.effect.observe, places))

    def take_steps(self, other: "Problem") -> None:
        """Begin with the steps of differentiation that another problem has found for unknowns of the same name."""
        for at, unknown in enumerate(self.unknowns):
            if unknown.name in other.index:
                self._steps[at] = other._steps[other.index[unknown.name]]

    def sizes(self, theta: Array) -> Array:
        """Return the natural size of each unknown; inner parameters are as large as they are."""
        tiny = 1e-3 * np.abs(theta)
        size = np.where(self.size > 0.0, self.size, np.maximum(np.abs(theta), tiny))
        return np.where(size > 0.0, size, 1.0)

    def respond(self, theta: Array, i: int) -> Response:
        """Simulate span i."""
        window = self.windows[i]
        linear = self._linear.copy()
        for place, at in enumerate(self._linear_at):
            if at >= 0:
                linear[place] = theta[at]
        table = self._parameters(theta)
        states = self._states_at_start(theta, table, i)
        at_u, at_v = self._starts[i]
        lag = theta[self._lags[i]] if self._lags[i] >= 0 else 0.0
        return simulate(
            self.system,
            linear,
            table,
            start=(float(theta[at_u]), float(theta[at_v])),
            states=states,
            samples=len(window),
            rate=window.rate,
            substeps=substeps_for(self._fastest(theta), window.rate, nonsmooth=self.system.nonsmooth),
            time=window.time,
            lag=float(lag),
            external=window.force if not window.estimates_mass else theta[self._weight] * window.force,
        )

    def states_at_start(self, theta: Array, i: int) -> dict[str, float]:
        """Return the internal states at the start of span i, by "effect.state0"."""
        states = self._states_at_start(theta, self._parameters(theta), i)
        return {
            f"{term.effect.name}.state{j}": float(states[row, j])
            for row, term in enumerate(self.physics)
            for j in range(term.effect.states)
        }

    def _parameters(self, theta: Array) -> Array:
        table = self._table.copy()
        for name, row, j in self._places:
            table[row, j] = theta[self.index[name]]
        for row, j, shared in self._shared:
            table[row, j] = theta[self.index[shared]]
        return table

    def _states_at_start(self, theta: Array, table: Array, i: int) -> Array:
        pre_release = self.windows[i].pre_release
        states = np.zeros((len(self.physics), STATES))
        for at, row, j in self._states[i]:
            states[row, j] = theta[at]
        if pre_release is not None:
            for row, term in enumerate(self.physics):
                if term.effect.rates is not None and term.effect.fading_memory:
                    states[row] = _driven(term, table[row], pre_release, int(self.system.addresses[row, 2]))
        return states

    def _fastest(self, theta: Array) -> float:
        fastest = self.frequency
        at = self.index.get("second_mass.w2")
        if at is not None:
            fastest = max(fastest, 0.6 * float(theta[at]))
        at = self.index.get("maxwell_element.tau")
        if at is not None:
            fastest = max(fastest, 0.05 / max(float(theta[at]), 1e-4))
        return fastest

    def read(self, theta: Array, i: int, response: Response) -> dict[str, Array]:
        """Return the predicted readings of span i, shape (n,) a channel."""
        window = self.windows[i]
        predicted: dict[str, Array] = {}
        for channel in window.channels:
            values = np.asarray(getattr(response, channel))
            if channel == "acceleration" and self._gains[i] >= 0:
                values = values * theta[self._gains[i]]
            predicted[channel] = values
        for at, channel, observe, places in self._sensors:
            if at == i:
                with np.errstate(all="ignore"):  # a motion that ran away is inf, and stays so
                    predicted[channel] = observe(window.clock, predicted[channel], theta[places])
        for channel, place in self._offsets[i].items():
            predicted[channel] = predicted[channel] + theta[place]
        return predicted

    def residual_of(self, i: int, predicted: dict[str, Array]) -> Array:
        """Return the misfit of span i in units of the noise, unused readings left out."""
        window = self.windows[i]
        parts = []
        for channel in window.channels:
            used = window.used[channel]
            parts.append((window.readings[channel][used] - predicted[channel][used]) / window.sigma[channel])
        return np.concatenate(parts)

    def residuals(self, theta: Array) -> Array:
        """Return the misfit of all spans in units of the noise; inf where the motion runs away."""
        return np.concatenate(
            [
                self.residual_of(i, self.read(theta, i, self.respond(theta, i)))
                for i in range(len(self.windows))
            ]
        )

    def linearise(self, theta: Array, *, skip: Mask | None = None) -> tuple[Array, Array]:
        """Return the misfit (n,) and its Jacobian (n, unknowns) by forward differences; zero where skipped.

        The steps are kept from call to call, each so large that it moves the readings well above rounding and well
        below the noise.
        """
        responses = [self.respond(theta, i) for i in range(len(self.windows))]
        parts = [self.residual_of(i, self.read(theta, i, r)) for i, r in enumerate(responses)]
        residual = np.concatenate(parts)
        jacobian = np.zeros((len(residual), len(theta)))
        if not np.isfinite(residual).all():
            return residual, jacobian
        size = self.sizes(theta)
        self._steps = np.where(self._steps > 0.0, self._steps, _STEP * size)
        for j in range(len(theta)):
            if skip is not None and skip[j]:
                continue
            for _ in range(_STEP_TRIALS):
                step, change = self._difference(theta, j, responses, residual)
                moved = float(np.sqrt(np.mean(change**2)))
                grow = float(
                    np.clip(_READABLE / moved if moved > 0.0 else np.inf, 1.0 / _STEP_GROWTH, _STEP_GROWTH)
                )
                before = self._steps[j]
                self._steps[j] = float(np.clip(before * grow, 1e-12 * size[j], _LONGEST_STEP * size[j]))
                if 0.03 < self._steps[j] / before < 30.0:
                    break
            smooth = np.abs(change) < _JUMP
            change[~smooth] = 0.0
            jacobian[:, j] = change / step
        return residual, jacobian

    def _difference(
        self, theta: Array, j: int, responses: list[Response], residual: Array
    ) -> tuple[float, Array]:
        """Return the step taken in unknown j and the change of the misfit, shape (n,)."""
        unknown = self.unknowns[j]
        moved = theta.copy()
        moved[j] += -self._steps[j] if theta[j] + self._steps[j] > self.high[j] else self._steps[j]
        step = float(moved[j] - theta[j])
        change = np.zeros(len(residual))
        first = 0
        for i, response in enumerate(responses):
            rows = slice(first, first + self._counts[i])
            first += self._counts[i]
            if unknown.window not in (-1, i):
                continue
            if unknown.simulated:
                response = self.respond(moved, i)
            elif j == self._lags[i]:
                response = Response(
                    response.displacement - step * response.velocity,
                    response.velocity - step * response.acceleration,
                    response.acceleration,
                )
            change[rows] = self.residual_of(i, self.read(moved, i, response)) - residual[rows]
        return step, np.where(np.isfinite(change), change, 0.0)


def _driven(term: Term, p: Array, pre_release: PreReleaseMotion, address: int) -> tuple[float, float]:
    """Return the internal states at the start of a span, from rest before the release along the measured motion."""
    assert term.effect.equilibrium_state is not None
    rest = term.effect.equilibrium_state(float(pre_release.displacement[0]), p)
    found: tuple[float, float] = states_after(
        address,
        pre_release.time,
        pre_release.displacement,
        pre_release.velocity,
        tuple(p),
        rest,
        _PRELUDE_STEPS,
    )
    return found


def _amplitude(window: FitWindow, w: float) -> float:
    powers = {"displacement": 0, "velocity": 1, "acceleration": 2}
    channel = window.channels[0]
    values = window.readings[channel][window.used[channel]]
    return float(np.ptp(values)) / 2.0 / w ** powers[channel] if len(values) else 1.0


def _unit(unit: str, length: str) -> str:
    return unit if length == "m" else _swap(unit, length)


def _swap(unit: str, length: str) -> str:
    out = []
    for i, letter in enumerate(unit):
        alone = (i == 0 or not unit[i - 1].isalpha()) and (i + 1 == len(unit) or not unit[i + 1].isalpha())
        out.append(length if letter == "m" and alone else letter)
    return "".join(out)
