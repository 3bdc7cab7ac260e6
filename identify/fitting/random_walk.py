"""A random walk of the linear spring and damper: how much of a misfit it explains, by its evidence.

On a rig neither is quite constant: it warms, creeps, rubs here and there. What they do slowly, and never twice alike, any
law of the amplitude or of time can follow in part. So before a law is named it must be better than such a walk. Its
strength is not known; the evidence is the mean over all strengths, with half of the weight on none (Jeffreys, *Theory of
Probability*, 1961, ch. 5). The misfit is taken for linear in the walk (linear mixed model; Laird and Ware, *Biometrics*
38, 1982), whose response is simulated.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from identify.arrays import Array
from identify.fitting.block_jacobian import BlockJacobian
from identify.fitting.fit import Fit
from identify.fitting.jacobian import JUMP, linearise
from identify.fitting.misfit_errors import with_covariance
from identify.fitting.problem import Problem
from identify.preprocessing.fit_window import FitWindow
from identify.priors import RIVALS_WITHIN

_MOST_KNOTS, _FEWEST_KNOTS = 24, 3
"""Times of one window between which spring and damper change at a constant rate; else one a cycle."""

_ALL_KNOTS = 64
"""About the most knots of all windows together: of many each has the fewest."""

_STRENGTHS = np.concatenate([[0.0], np.geomspace(1e-6, 1.0, 19)])
"""Standard deviation of a walk after one second, of the stiffness in units of itself, of the damping in those of omega."""

_EACH = 1.0
"""Nats that one of the two must bring to be stated: Akaike's, of one number more."""

_PROBE = 1e-5
"""Share of the acceleration that the probed force has at first."""

_MOVED = 0.02
"""Root mean square change of the readings, in units of the noise, at which a response is taken."""

_ROUNDS = 10
"""How often at most the misfit is linearised again at a motion with a walk."""

_FAR, _ALIKE = 2.0, 0.1
"""Reduced chi-square above which no floor lies, and the relative change of two predictions that end the rounds there."""

_PICARD = 12
"""How often the motion with a walk is simulated, the force of the walk taken along the last one."""

_AS_PREDICTED = 1.0
"""Difference of chi-square up to which a simulation with a walk leaves what was predicted."""

_SINGULAR = 1e-12


@dataclass(frozen=True, eq=False)
class Place:
    """Where the misfit of the fit `found` is linearised: its unknowns (unknowns,), misfit (readings,) and Jacobian.

    The `walk` that acts there are the steps of the stiffness and then those of the damping, (2 steps,), in units of one
    standard deviation of a walk of variance 1 after one second.
    """

    found: Fit
    problem: Problem
    theta: Array
    residual: Array
    jacobian: BlockJacobian
    walk: Array
    knots: "_Knots"

    @property
    @np.errstate(over="ignore", invalid="ignore")  # a motion that diverges has no response
    def columns(self) -> Array:
        """The change of the misfit by each step of the walks of stiffness and damping, (readings, 2 steps).

        Simulated each time: of a long record they fill a tenth of a gigabyte.
        """
        problem, knots, omega, blocks = self.problem, self.knots, self.problem.frequency, []
        for i, window in enumerate(problem.windows):
            motion = problem.respond(self.theta, i, problem.substeps(self.theta, i, tangent=True))
            ramps = [np.interp(window.clock, knots.times[i], one) for one in np.eye(len(knots.times[i]))]
            by_step = [
                changes_by(problem, self.theta, i, [ramp * force for ramp in ramps]) @ knots.values[i]
                for force in (omega**2 * motion.displacement, omega * motion.velocity)
            ]
            blocks.append(np.column_stack(by_step))
        return np.concatenate([*blocks, np.zeros((len(problem.expected), 2 * knots.steps))])


@dataclass(frozen=True, eq=False)
class RandomWalk:
    """The random walk of the linear spring and damper that best explains the misfit of a fit.

    `evidence` is the logarithm (nats) of the odds for a walk of unknown strength, or none, against none. `stiffness` and
    `damping` are the likeliest standard deviations after one second (1/sqrt(s)), relative to the linear stiffness and to the
    angular frequency of the motion. `left` is the chi-square that the likeliest walk leaves, with its `draws` (2 steps,) in
    those deviations, and `without` that without any walk. `misfit` is what the fit's own unknowns cannot follow of the
    misfit without any walk, and `ahead` the misfit that is predicted with this one, (readings,) each, linear about `place`.
    `settled` says that a simulation with the walk leaves as much as these predict.
    """

    evidence: float
    stiffness: float
    damping: float
    left: float
    without: float
    draws: Array = field(repr=False)
    misfit: Array = field(repr=False)
    ahead: Array = field(repr=False)
    place: Place = field(repr=False)
    settled: bool = True

    @property
    def reduced(self) -> float:
        """The reduced chi-square that the likeliest walk leaves."""
        return self.left / max(self.place.found.degrees, 1)

    @property
    def sizes(self) -> Array:
        """The standard deviation of each step, (2 steps,), as the `walk` of a place is counted."""
        return np.repeat([self.stiffness, self.damping], self.place.knots.steps)

    @property
    def follows(self) -> Array:
        """What steps of one standard deviation change, less what the fit's own unknowns follow of it, (readings, steps)."""
        if not (self.stiffness or self.damping):
            return np.zeros((len(self.misfit), 0))
        return np.asarray(self.place.jacobian.free(self.place.columns) * self.sizes)

    @cached_property
    def simulated(self) -> "RandomWalk":
        """The walk with which the motion is simulated, and linearised again there until that leaves what was predicted.

        Gauss-Newton, a few rounds at most.
        """
        if not (self.stiffness or self.damping):
            return self
        best, left = self, self.without
        for _ in range(_ROUNDS):
            moved = _moved(best)
            cost = np.inf if moved is None else _square(moved) + float(best.draws @ best.draws)
            if moved is None or not cost < left:
                break
            as_predicted = abs(cost - best.left) < _AS_PREDICTED
            before, best, left = best, _likeliest(moved, self.without), cost
            if as_predicted:
                return best
            if best.reduced > _FAR and abs(best.left - before.left) < _ALIKE * best.left:
                break
        return replace(best, settled=False)


def walk_beside(found: Fit) -> RandomWalk:
    """Estimate the random walk of spring and damper that explains the residual of a fit, which is taken for linear in it."""
    knots = _Knots.of(found.problem)
    place = Place(found, found.problem, found.theta, *found.linearised, np.zeros(2 * knots.steps), knots)
    return _likeliest(place, _square(place))


def _square(place: Place) -> float:
    """Return the sum of squares of what the fit's own unknowns cannot follow of a misfit."""
    free = place.jacobian.free(place.residual)
    return float(free @ free)


def _likeliest(place: Place, without: float) -> RandomWalk:
    """Weigh walks of every strength about a place and return the likeliest; `without` is chi-square without any walk."""
    is_spring = np.repeat([True, False], place.knots.steps)
    columns = place.columns
    free = place.jacobian.free(np.column_stack([place.residual, columns]))
    walk = free[:, 1:]
    misfit = free[:, 0] - walk @ place.walk
    along, products = walk.T @ misfit, walk.T @ walk
    likelihood, explained = np.zeros((2, len(_STRENGTHS), len(_STRENGTHS)))
    for row, stiffness in enumerate(_STRENGTHS):
        scale = np.where(is_spring, stiffness, _STRENGTHS[:, None])
        both = products * scale[:, :, None] * scale[:, None, :]
        likelihood[row], explained[row] = explained_by(both, along * scale)
    unwalked = float(misfit @ misfit)
    likelihood += 0.5 * (without - unwalked)
    likelihood[0, 0], explained[0, 0] = 0.0, unwalked - without
    is_there = np.array(_STRENGTHS > 0.0, dtype=float)
    stated = likelihood - _EACH * (is_there[:, None] + is_there)
    i, j = np.unravel_index(np.argmax(stated), stated.shape)
    walks = likelihood.ravel()[1:]
    mean = np.logaddexp.reduce(walks) - np.log(len(walks))
    sizes = np.where(is_spring, _STRENGTHS[i], _STRENGTHS[j])
    own = np.eye(len(sizes)) + products * np.outer(sizes, sizes)
    draws = -np.linalg.solve(own, along * sizes)
    return RandomWalk(
        evidence=float(np.logaddexp(0.0, mean) - np.log(2.0)),
        stiffness=float(_STRENGTHS[i]),
        damping=float(_STRENGTHS[j]),
        left=unwalked - float(explained[i, j]),
        without=without,
        draws=draws,
        misfit=misfit,
        ahead=place.residual + columns @ (sizes * draws - place.walk),
        place=place,
    )


def _moved(walk: RandomWalk) -> Place | None:
    """Simulate a fit with a walk, its own unknowns following as predicted, and linearise there; None where that diverges."""
    place, found, steps = walk.place, walk.place.found, walk.sizes * walk.draws
    normal, gradient = place.jacobian.normal(), place.jacobian.gradient(walk.ahead)
    own = np.sqrt(np.where(np.diag(normal) > 0.0, np.diag(normal), 1.0))
    change = np.linalg.lstsq(normal / np.outer(own, own), -gradient / own, rcond=_SINGULAR)[0] / own
    problem = found.problem
    theta = np.clip(place.theta + change, problem.low, problem.high)
    acting: list[Array] = []
    for i, window in enumerate(problem.windows):
        softer, looser = (place.knots.path(i, window, own_steps) for own_steps in np.split(steps, 2))
        force = np.zeros(len(window))
        for _ in range(_PICARD):
            motion = problem.respond(theta, i, extra=-force)
            if not np.isfinite(motion.velocity).all():
                return None
            force = problem.frequency**2 * softer * motion.displacement
            force += problem.frequency * looser * motion.velocity
        acting.append(-force)
    moved = Problem(found.model, found.windows, found.frequency, acting=tuple(acting))
    moved.steps = problem.steps.copy()
    return Place(found, moved, theta, *linearise(moved, theta), steps, place.knots)


def with_walk_errors(stated: Fit, walk: RandomWalk) -> Fit:
    """Widen the `stated` errors of a fit by what the random walk beside it does to the values of least squares.

    A walk of covariance W changes them by C J' W J C, with C the covariance under noise alone and J the Jacobian. An
    unknown at its bound is free, as it is in C.
    """
    found = walk.place.found
    if walk.evidence <= RIVALS_WITHIN:
        return stated
    scores = [found.linearised[1].gradient(column) for column in (walk.place.columns * walk.sizes).T]
    moved = found.covariance @ np.column_stack(scores)
    return with_covariance(stated, stated.covariance + moved @ moved.T)


def explained_by(products: Array, along: Array) -> tuple[Array, Array]:
    """Return the gain of log-likelihood by columns with variance 1, and the chi-square they explain, (...,).

    `products` (..., columns, columns) are those of the columns with one another, `along` (..., columns) those with the
    misfit.
    """
    n = along.shape[-1]
    bordered = np.zeros((*along.shape[:-1], n + 1, n + 1))
    bordered[..., :n, :n] = products
    bordered[..., range(n), range(n)] += 1.0
    bordered[..., n, :n] = along
    bordered[..., n, n] = 1.0 + (along**2).sum(axis=-1)  # more than is explained
    factor = np.linalg.cholesky(bordered)  # its last row solves for the misfit
    explained = (factor[..., n, :n] ** 2).sum(axis=-1)
    size = np.diagonal(factor, axis1=-2, axis2=-1)[..., :n]
    return 0.5 * explained - np.log(size).sum(axis=-1), explained


@dataclass(frozen=True)
class _Knots:
    """Times between which spring and damper change at a constant rate, (knots,) s since the release, for each window.

    `values[i]` are a walk's values there by its steps, (knots, steps): it has variance 1 after one second, goes on from
    window to window of a release, and begins anew with each release.
    """

    times: tuple[Array, ...]
    values: tuple[Array, ...]

    @classmethod
    def of(cls, problem: Problem) -> "_Knots":
        """Place one knot a cycle, between the fewest and the most."""
        times = []
        for window in problem.windows:
            cycles = len(window) / window.rate * problem.frequency / (2.0 * np.pi)
            most = max(_ALL_KNOTS // len(problem.windows), _FEWEST_KNOTS)
            count = int(np.clip(cycles, _FEWEST_KNOTS, min(most, _MOST_KNOTS))) + 1
            times.append(np.linspace(window.clock[0], window.clock[-1], count))
        counts = [len(own) for own in times]
        release = np.repeat([window.release for window in problem.windows], counts)
        goes_on = release[1:] == release[:-1]
        length = np.concatenate([[0.0], np.where(goes_on, np.diff(np.concatenate(times)), 0.0)])
        values = np.tril(release[:, None] == release) * np.sqrt(np.maximum(length, 0.0))
        return cls(tuple(times), tuple(np.split(values, np.cumsum(counts[:-1]))))

    @property
    def steps(self) -> int:
        """Number of steps of a walk."""
        return int(self.values[0].shape[1])

    def path(self, i: int, window: FitWindow, steps: Array) -> Array:
        """Return a walk of some steps along window i, (n,)."""
        return np.interp(window.clock, self.times[i], self.values[i] @ steps)


def changes_by(problem: Problem, theta: Array, i: int, forces: list[Array]) -> Array:
    """Return the change of window i's misfit by each of some weak forces per unit mass along its motion, (n, forces)."""
    substeps = problem.substeps(theta, i, tangent=True)
    base = problem.residual_of(i, problem.read(theta, i, problem.respond(theta, i, substeps)))

    def change(force: Array, step: float) -> Array:
        moved = problem.respond(theta, i, substeps, extra=-step * force)
        return np.asarray(problem.residual_of(i, problem.read(theta, i, moved)) - base)

    whole = change(np.sum(forces, axis=0), _PROBE)
    size = float(np.sqrt(np.mean(whole**2)))
    if not 0.0 < size < np.inf:  # the motion diverges
        return np.zeros((len(base), len(forces)))
    step = _PROBE * _MOVED / size
    moved = np.column_stack([change(force, step) for force in forces])
    return np.asarray(np.where(np.abs(moved) < JUMP, moved, 0.0) / step)
