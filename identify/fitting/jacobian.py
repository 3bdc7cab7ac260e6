"""The Jacobian: how the misfit changes with each unknown, by forward differences whose steps are kept from call to call."""

import numpy as np

from identify.arrays import Array, Mask
from identify.fitting.problem import Problem
from identify.model.simulate import Response

_STEP = 1e-5
_STEP_TRIALS = 4
_STEP_GROWTH = 1e3
_LONGEST_STEP = 1e-2
_JUMP = 0.5
"""Change of a reading by a small step, in units of the noise, from which on a reversal has crossed its sample."""

_READABLE = 3e-3
"""Root mean square change of the readings, in units of the noise, at which a difference is taken."""


def linearise(problem: Problem, theta: Array, *, skip: Mask | None = None) -> tuple[Array, Array]:
    """Return the misfit (n,) and its Jacobian (n, unknowns) by forward differences; zero where skipped.

    The problem keeps the steps, each so large that it moves the readings well above rounding and well below the noise.
    """
    responses = problem.responses(theta)
    parts = [problem.residual_of(i, problem.read(theta, i, r)) for i, r in enumerate(responses)]
    residual = np.concatenate(parts)
    jacobian = np.zeros((len(residual), len(theta)))
    if not np.isfinite(residual).all():
        return residual, jacobian
    size = problem.sizes(theta)
    problem.steps = np.where(problem.steps > 0.0, problem.steps, _STEP * size)
    for j in range(len(theta)):
        if skip is not None and skip[j]:
            continue
        for _ in range(_STEP_TRIALS):
            step, change = _difference(problem, theta, j, responses, parts)
            if not _improve_step(problem, j, change, float(size[j])):
                break
        change[np.abs(change) >= _JUMP] = 0.0
        jacobian[:, j] = change / step
    return residual, jacobian


def take_steps(problem: Problem, other: Problem) -> None:
    """Begin with the steps of differentiation that another problem has found for unknowns of the same name."""
    for at, unknown in enumerate(problem.unknowns):
        if unknown.name in other.index:
            problem.steps[at] = other.steps[other.index[unknown.name]]


def _improve_step(problem: Problem, j: int, change: Array, size: float) -> bool:
    """Adapt the step of unknown j to the change that it made; return whether it was so wrong that it is taken again."""
    with np.errstate(over="ignore"):  # a motion that nearly ran away: the step shrinks as far as it may
        moved = float(np.sqrt(np.mean(change**2)))
    grow = float(np.clip(_READABLE / moved if moved > 0.0 else np.inf, 1.0 / _STEP_GROWTH, _STEP_GROWTH))
    before = problem.steps[j]
    problem.steps[j] = float(np.clip(before * grow, 1e-12 * size, _LONGEST_STEP * size))
    return not 0.03 < problem.steps[j] / before < 30.0


def _difference(
    problem: Problem, theta: Array, j: int, responses: list[Response], parts: list[Array]
) -> tuple[float, Array]:
    """Return the step taken in unknown j and the change of the misfit, shape (n,)."""
    unknown, size = problem.unknowns[j], problem.steps[j]
    moved = theta.copy()
    moved[j] += -size if theta[j] + size > problem.high[j] else size
    step = float(moved[j] - theta[j])
    changes = []
    for i, (response, part) in enumerate(zip(responses, parts, strict=True)):
        if unknown.window not in (-1, i):
            changes.append(np.zeros(len(part)))
            continue
        if unknown.simulated:
            response = problem.respond(moved, i)
        elif j == problem.layout.releases[i].lag:
            response = Response(
                response.displacement - step * response.velocity,
                response.velocity - step * response.acceleration,
                response.acceleration,
            )
        changes.append(problem.residual_of(i, problem.read(moved, i, response)) - part)
    change = np.concatenate(changes)
    return step, np.where(np.isfinite(change), change, 0.0)
