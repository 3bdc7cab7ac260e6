"""The problem that a fit solves: from parameters to the misfit of predicted readings, in units of the noise."""

from dataclasses import dataclass, replace

import numpy as np

from identify.arrays import Array
from identify.effects.compiled import STATES
from identify.effects.force_effect import LinearPart
from identify.fitting.block_jacobian import BlockPattern
from identify.fitting.parameter_layout import NOWHERE, ParameterLayout, amplitude_of
from identify.model.model import Model
from identify.model.simulate import Response, make_system, simulate, substeps_for
from identify.preprocessing.fit_window import FitWindow

_PRE_RELEASE_STEPS = 16
_COARSE, _ROUGH = 2.0, 4.0
"""How many times longer steps are beside a large misfit; and far from the readings, or where only a slope is wanted."""


@dataclass(frozen=True, eq=False)
class Simulated:
    """One window simulated at its own unknowns, (own,), and its misfit in units of the noise, (n,)."""

    unknowns: Array
    response: Response
    misfit: Array


class Problem:
    """A model on one or more windows: the physics is shared, each window has nuisance parameters of its own.

    The nuisances are the state at the start of the window, the internal states of effects with memory, and,
    where there are two channels, lag and gain; and an offset of every channel. Where the windows say so, each release has
    a linear spring and damper of its own near those of all: what they are off, in standard deviations, is read as a last
    stretch of the misfit, which no window has. `steps` (unknowns,) are the steps of
    differentiation, 0 until they are known. A `coarse` problem is integrated in longer steps: what they are off by shows
    beside the noise, but not beside a misfit that is much larger. One that is `far` off besides compares every second
    reading, or fewer, where they are many to a cycle. `acting` are further forces per unit mass on the windows, (n,) each.
    """

    def __init__(
        self,
        model: Model,
        windows: tuple[FitWindow, ...],
        frequency: float,
        *,
        coarse: bool = False,
        far: bool = False,
        acting: tuple[Array, ...] = (),
    ) -> None:
        if far:
            windows = tuple(window.at_few_readings(frequency) for window in windows)
        self.model = model
        self.windows = windows
        self.acting = acting
        self.frequency = frequency
        self.longer = _ROUGH if far else _COARSE if coarse else 1.0
        self.layout = ParameterLayout(model, windows, frequency)
        self.unknowns = tuple(self.layout.unknowns)
        system = make_system(tuple(term.force for term in self.layout.forces))
        # Steps end at reversals even where dry friction is just zero: a slope there is that of friction.
        dry = system.has_friction or self.layout.linear[LinearPart.DRY_FRICTION] != NOWHERE
        self.system = replace(system, has_friction=dry)
        self.low = np.array([u.low for u in self.unknowns])
        self.high = np.array([u.high for u in self.unknowns])
        self.size = np.array([u.size for u in self.unknowns])
        self.index = {u.name: i for i, u in enumerate(self.unknowns)}
        self.expected = [j for j, u in enumerate(self.unknowns) if u.deviates != NOWHERE]
        release = [window.release for window in windows]
        self._own = [[j for j in self.expected if release[self.unknowns[j].window] == one] for one in release]
        moves: list[tuple[int, ...] | None]
        moves = [None if u.window == NOWHERE else (u.window,) for u in self.unknowns]
        for j, u in enumerate(self.unknowns):
            if u.whole_release:
                moves[j] = tuple(i for i, one in enumerate(release) if one == release[u.window])
        self.pattern = BlockPattern.of(moves, len(windows), self.expected)
        strengths = {str(term.strength) for term in model.forces}
        self._strengths = [i for i, u in enumerate(self.unknowns) if u.name in strengths]
        self.steps = np.zeros(len(self.unknowns))
        self._paths = [frequency * amplitude_of(window, frequency) / window.rate for window in windows]
        self._kept: list[list[Simulated]] = [[] for _ in windows]

    def theta(self, values: dict[str, float]) -> Array:
        """Return the unknowns, (unknowns,), at values by name; 0 for one without."""
        return np.array([values.get(unknown.name, 0.0) for unknown in self.unknowns])

    def sizes(self, theta: Array) -> Array:
        """Return the natural size of each unknown; that of an inner parameter is its value."""
        size = np.where(self.size > 0.0, self.size, np.abs(theta))
        return np.where(size > 0.0, size, 1.0)

    def substeps(self, theta: Array, i: int, *, tangent: bool = False) -> int:
        """Choose the number of integration steps a sample of window i, or for a `tangent` the number its slope needs."""
        return self._substeps(self._table(self.within(theta, i), i), i, _ROUGH if tangent else self.longer)

    def _substeps(self, table: Array, i: int, longer: float) -> int:
        rate, nonsmooth = self.windows[i].rate, self.system.nonsmooth
        fastest = self._fastest_rate(table, rate)
        fine = substeps_for(fastest, rate, nonsmooth=nonsmooth)
        fewer = substeps_for(fastest, rate, nonsmooth=nonsmooth, longer=longer)
        return int(min(max(fewer, np.ceil(self._steps_of_memory(table, i))), fine))

    def within(self, theta: Array, i: int) -> Array:
        """Return the unknowns as window i sees them: shared ones with the deviation of its release, over its inertia."""
        if not self._own[i] and self.windows[i].lightness == 1.0:
            return theta
        theta = theta.copy()
        for j in self._own[i]:
            theta[self.unknowns[j].deviates] += self.deviation(theta, j)
        theta[self._strengths] *= self.windows[i].lightness
        return theta

    def deviation(self, theta: Array, j: int) -> float:
        """Return a release's deviation, unknown j, limited so that its value stays within the bound."""
        shared = self.unknowns[j].deviates
        return float(max(theta[j], self.low[shared] - theta[shared]))

    @property
    def deviations(self) -> dict[int, list[int]]:
        """The places of the deviations from each shared unknown that has some, by its place."""
        shared = {self.unknowns[j].deviates for j in self.expected}
        return {at: [j for j in self.expected if self.unknowns[j].deviates == at] for at in shared}

    def respond(
        self, theta: Array, i: int, substeps: int | None = None, *, extra: Array | None = None
    ) -> Response:
        """Simulate window i in as many steps a sample as given, or as it needs, with an `extra` force per unit mass (n,)."""
        window, places = self.windows[i], self.layout.releases[i]
        theta = self.within(theta, i)
        linear = np.array([theta[at] if at != NOWHERE else 0.0 for at in self.layout.linear])
        table = self._table(theta, i)
        at_u, at_v = places.start
        lag = theta[places.lag] if places.lag != NOWHERE else 0.0
        return simulate(
            self.system,
            linear,
            table,
            start=(float(theta[at_u]), float(theta[at_v])),
            states=self._states_at_start(theta, table, i),
            samples=len(window),
            rate=window.rate,
            substeps=self._substeps(table, i, self.longer) if substeps is None else substeps,
            time=window.time,
            lag=float(lag),
            external=self._external(theta, i, extra),
        )

    def _external(self, theta: Array, i: int, extra: Array | None) -> Array | None:
        """Return the external force per unit mass on window i, (n,); None where there is none."""
        force = self.windows[i].force
        if force is not None and self.windows[i].estimates_mass:
            force = theta[self.layout.force_gain] * force
        acting = self.acting[i] if self.acting else None
        parts = [one for one in (force, acting, extra) if one is not None]
        return np.asarray(sum(parts)) if parts else None

    def motions(self, theta: Array) -> list[Simulated]:
        """Simulate all windows; a misfit is inf where its motion diverges.

        Those whose unknowns equal one of their last two motions are taken from memory: what was tried is then linearised
        and read, or left for what was before; a start that changes moves one window only.
        """
        return [self._motion(theta, i) for i in range(len(self.windows))]

    def _motion(self, theta: Array, i: int) -> Simulated:
        own, kept = theta[self.pattern.places[i]], self._kept[i]
        for motion in kept:
            if np.array_equal(motion.unknowns, own):
                return motion
        response = self.respond(theta, i)
        kept.insert(0, Simulated(own, response, self.residual_of(i, self.read(theta, i, response))))
        del kept[2:]
        return kept[0]

    def states_at_start(self, theta: Array, i: int) -> dict[str, float]:
        """Return the internal states at the start of window i, by "effect.state0"."""
        theta = self.within(theta, i)
        states = self._states_at_start(theta, self._table(theta, i), i)
        return {
            str(term.state(j)): float(states[row, j])
            for row, term in enumerate(self.layout.forces)
            for j in range(term.force.states)
        }

    def _table(self, theta: Array, i: int) -> Array:
        table = self.layout.held.copy()
        for cell in (*self.layout.cells, *self.layout.releases[i].forces):
            table[cell.row, cell.column] = theta[cell.unknown]
        return table

    def _states_at_start(self, theta: Array, table: Array, i: int) -> Array:
        """Return the internal states, (forces, 2): those that are unknowns, and those that the pre-release motion gives."""
        states = np.zeros((len(self.layout.forces), STATES))
        for cell in self.layout.releases[i].states:
            states[cell.row, cell.column] = theta[cell.unknown]
        before = self.windows[i].pre_release
        if before is not None:
            for row, term in enumerate(self.layout.forces):
                effect, p = term.force, tuple(table[row])
                if effect.rates is not None and effect.fading_memory:
                    rest = effect.states_at_rest(float(before.displacement[0]), p)
                    motion = (before.time, before.displacement, before.velocity)
                    states[row] = effect.states_along(p, *motion, rest, steps=_PRE_RELEASE_STEPS)[-1]
        return states

    def _steps_of_memory(self, table: Array, i: int) -> float:
        """Count the steps a sample that window i needs so that friction with memory yields over at least one step."""
        ways = [
            0.0 if term.force.gives_way is None else term.force.gives_way(row)
            for row, term in zip(table, self.layout.forces, strict=True)
            if term.force.nonsmooth and term.force.states
        ]
        return max((self._paths[i] / way if way > 0.0 else np.inf for way in ways), default=0.0)

    def _fastest_rate(self, table: Array, sampling: float) -> float:
        """Return the angular frequency (rad/s) that the integration must resolve of readings at a rate (Hz).

        What an effect does far beyond the readings is not followed: there the run diverges, and so bounds the fit.
        """
        fastest = self.frequency
        for row, term in zip(table, self.layout.forces, strict=True):
            rate = term.force.fastest_rate
            fastest = fastest if rate is None else max(fastest, min(rate(row), sampling))
        return fastest

    def read(self, theta: Array, i: int, response: Response) -> dict[str, Array]:
        """Return the predicted readings of window i, shape (n,) a channel."""
        window, places = self.windows[i], self.layout.releases[i]
        predicted: dict[str, Array] = {}
        for channel in window.channels:
            values = np.asarray(getattr(response, channel))
            if channel == "acceleration" and places.gain != NOWHERE:
                values = values * theta[places.gain]
            predicted[channel] = values
        for term, at in places.faults:
            with np.errstate(all="ignore"):  # a motion that diverged is inf, and stays so
                predicted[term.channel] = term.fault.observe(window.clock, predicted[term.channel], theta[at])
        for channel, place in places.offsets.items():
            predicted[channel] = predicted[channel] + theta[place]
        return predicted

    def residual_of(self, i: int, predicted: dict[str, Array]) -> Array:
        """Return the misfit of window i in units of the noise, coloured noise whitened, unused readings left out."""
        window = self.windows[i]
        return np.concatenate(
            [window.compared(c, window.readings[c] - predicted[c]) for c in window.channels]
        )

    def off_expected(self, theta: Array) -> list[Array]:
        """Return the deviations of each release, in standard deviations, as one array; empty where it may not differ."""
        if not self.expected:
            return []
        return [np.array([theta[j] / self.unknowns[j].std for j in self.expected])]

    def residuals(self, theta: Array) -> Array:
        """Return the misfit of all windows in units of the noise; inf where the motion diverges."""
        return np.concatenate([*(motion.misfit for motion in self.motions(theta)), *self.off_expected(theta)])
