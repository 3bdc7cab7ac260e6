"""A random walk of the linear spring and damper: how much of a misfit it explains, by its evidence.

On a rig neither is quite constant: it warms, creeps, rubs here and there. What they do slowly, and never twice alike, any
law of the amplitude or of time can follow in part. So before a law is named it must be better than such a walk. Its
strength is not known; the evidence is the mean over all strengths, with half of the weight on none (Jeffreys, *Theory of
Probability*, 1961, ch. 5). The misfit is taken for linear in the walk (linear mixed model; Laird and Ware, *Biometrics*
38, 1982), whose response is simulated.
"""

from dataclasses import dataclass, field

import numpy as np

from identify.arrays import Array
from identify.fitting.fit import Fit
from identify.fitting.problem import Problem

_MOST_KNOTS, _FEWEST_KNOTS = 24, 3
"""Times of one window between which spring and damper change at a constant rate; else one a cycle."""

_ALL_KNOTS = 100
"""About the most knots of all windows together: of many each has the fewest."""

_STRENGTHS = np.concatenate([[0.0], np.geomspace(1e-6, 1.0, 19)])
"""Standard deviation of a walk after one second, of the stiffness in units of itself, of the damping in those of omega."""

_EACH = 1.0
"""Nats that one of the two must bring to be stated: Akaike's, of one number more."""

_PROBE = 1e-5
"""Share of the acceleration that the probed force has at first."""

_MOVED = 0.02
"""Root mean square change of the readings, in units of the noise, at which a response is taken."""

_JUMP = 0.5
"""Change of a reading, in units of the noise, from which on a reversal has crossed its sample."""


@dataclass(frozen=True)
class RandomWalk:
    """The random walk of the linear spring and damper that best explains the misfit of a fit.

    `evidence` is the logarithm (nats) of the odds for a walk of unknown strength, or none, against none. `stiffness` and
    `damping` are the likeliest standard deviations after one second (1/sqrt(s)), relative to the linear stiffness and to the
    angular frequency of the motion. `reduced` is the reduced chi-square that the likeliest walk leaves, and `follows` what
    its steps of one standard deviation change of the misfit, less what the fit's own unknowns follow, (readings, steps).
    """

    evidence: float
    stiffness: float
    damping: float
    reduced: float
    follows: Array = field(default_factory=lambda: np.zeros((0, 0)), repr=False, compare=False)


def walk_beside(found: Fit) -> RandomWalk:
    """Estimate the random walk of spring and damper that explains the residual of a fit."""
    problem, (residual, jacobian) = found.problem, found.linearised
    columns = [_responses(problem, found.theta, kind) for kind in ("stiffness", "damping")]
    is_spring = np.repeat([True, False], [one.shape[1] for one in columns])
    free = jacobian.free(np.column_stack([residual, *columns]))
    misfit, walk = free[:, 0], free[:, 1:]
    square, along, products = float(misfit @ misfit), walk.T @ misfit, walk.T @ walk
    likelihood, explained = np.zeros((2, len(_STRENGTHS), len(_STRENGTHS)))
    for row, stiffness in enumerate(_STRENGTHS):
        scale = np.where(is_spring, stiffness, _STRENGTHS[:, None])
        both = products * scale[:, :, None] * scale[:, None, :]
        likelihood[row], explained[row] = explained_by(both, along * scale)
    is_there = np.array(_STRENGTHS > 0.0, dtype=float)
    stated = likelihood - _EACH * (is_there[:, None] + is_there)
    i, j = np.unravel_index(np.argmax(stated), stated.shape)
    walks = likelihood.ravel()[1:]
    mean = np.logaddexp.reduce(walks) - np.log(len(walks))
    return RandomWalk(
        float(np.logaddexp(0.0, mean) - np.log(2.0)),
        float(_STRENGTHS[i]),
        float(_STRENGTHS[j]),
        (square - float(explained[i, j])) / max(found.degrees, 1),
        walk * np.where(is_spring, _STRENGTHS[i], _STRENGTHS[j]) if i or j else walk[:, :0],
    )


def explained_by(products: Array, along: Array) -> tuple[Array, Array]:
    """Return the gain of log-likelihood by columns with variance 1, and the chi-square they explain, (...,).

    `products` (..., columns, columns) are those of the columns with one another, `along` (..., columns) those with the
    misfit.
    """
    factor = np.linalg.cholesky(np.eye(along.shape[-1]) + products)
    explained = (np.linalg.solve(factor, along[..., None])[..., 0] ** 2).sum(axis=-1)
    return 0.5 * explained - np.log(np.diagonal(factor, axis1=-2, axis2=-1)).sum(axis=-1), explained


def _responses(problem: Problem, theta: Array, kind: str) -> Array:
    """Return the change of the misfit by each step of one of the two walks, of one standard deviation, (readings, steps).

    A walk has variance 1 after one second; it goes on from window to window of a release, and begins anew with each release.
    """
    blocks: list[Array] = []
    times: list[tuple[int, float]] = []
    for i, window in enumerate(problem.windows):
        cycles = len(window) / window.rate * problem.frequency / (2.0 * np.pi)
        most = max(_ALL_KNOTS // len(problem.windows), _FEWEST_KNOTS)
        count = int(np.clip(cycles, _FEWEST_KNOTS, min(most, _MOST_KNOTS))) + 1
        knots = np.linspace(window.clock[0], window.clock[-1], count)
        motion = problem.respond(theta, i, problem.substeps(theta, i, tangent=True))
        omega = problem.frequency
        force = omega**2 * motion.displacement if kind == "stiffness" else omega * motion.velocity
        ramps = [np.interp(window.clock, knots, one) * force for one in np.eye(count)]
        blocks.append(np.column_stack(changes_by(problem, theta, i, ramps)))
        times += [(window.release, knot) for knot in knots.tolist()]
    blocks.append(np.zeros((len(problem.expected), 0)))
    parts = np.split(_steps(times), np.cumsum([block.shape[1] for block in blocks[:-1]]))
    return np.concatenate([block @ part for block, part in zip(blocks, parts, strict=True)])


def _steps(times: list[tuple[int, float]]) -> Array:
    """Return a walk's values at knots, each a release and a time (s), by its steps, (knots, steps)."""
    release = np.array([one for one, _ in times])
    time = np.array([time for _, time in times])
    goes_on = release[1:] == release[:-1]
    length = np.concatenate([[0.0], np.where(goes_on, np.diff(time), 0.0)])
    after = np.tril(release[:, None] == release)
    return np.asarray(after * np.sqrt(np.maximum(length, 0.0)))


def changes_by(problem: Problem, theta: Array, i: int, forces: list[Array]) -> list[Array]:
    """Return the change of window i's misfit by each of some weak forces per unit mass along its motion, (n,) each."""
    substeps = problem.substeps(theta, i, tangent=True)
    base = problem.residual_of(i, problem.read(theta, i, problem.respond(theta, i, substeps)))

    def change(force: Array, step: float) -> Array:
        moved = problem.respond(theta, i, substeps, extra=-step * force)
        return np.asarray(problem.residual_of(i, problem.read(theta, i, moved)) - base)

    whole = change(np.sum(forces, axis=0), _PROBE)
    size = float(np.sqrt(np.mean(whole**2)))
    if not 0.0 < size < np.inf:  # the motion diverges
        return [np.zeros_like(base) for _ in forces]
    step = _PROBE * _MOVED / size
    found = []
    for force in forces:
        moved = change(force, step)
        found.append(np.where(np.abs(moved) < _JUMP, moved, 0.0) / step)
    return found
