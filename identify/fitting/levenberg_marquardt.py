"""Levenberg-Marquardt within bounds, which differentiates again only where a step gained less than predicted."""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, Mask
from identify.fitting.block_jacobian import BlockJacobian
from identify.fitting.jacobian import linearise
from identify.fitting.problem import Problem

MOST_STEPS = 40
_TRIALS = 12
_CONFIRMATIONS = 3
_CREEPS = 0.02
_UNDAMPED = 1e-3
_SINGULAR = 1e-12
"""Least damping, beside which rounding errors of the normal equations are nothing."""

_NEAR_FLOOR = 2.0
"""Reduced chi-square up to which all that is left counts as noise."""

_AS_PREDICTED = 0.7
"""Share of the predicted drop of chi-square from which on the Jacobian counts as good."""


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where a minimisation ended.

    The unknowns, chi-square, the Jacobian last used, whether it was taken there (`exact`), and whether no step was
    predicted to gain anything any more (`settled`); or that it crept and was `given_up`.
    """

    theta: Array
    cost: float
    jacobian: BlockJacobian
    exact: bool
    settled: bool
    given_up: bool = False


@dataclass(frozen=True, eq=False)
class _Step:
    theta: Array
    residual: Array
    cost: float
    predicted: float
    damping: float


def minimise(
    problem: Problem,
    theta: Array,
    *,
    steps: int = MOST_STEPS,
    tolerance: float = 0.02,
    held: Mask | None = None,
    goal: float = 0.0,
    damping: float = _UNDAMPED,
) -> Minimum:
    """Lower chi-square from `theta`, until a step gains less than `tolerance`.

    Given up where two steps on end gain less than 2 % of what is missing to a `goal` above 0, which is then not reached
    in as many steps as there are. Unknowns that are `held` stay where they are. `damping` is that of the first step.
    Between exact Jacobians each step mends the last one.
    """
    theta = np.clip(theta, problem.low, problem.high)
    never = np.zeros(len(theta), dtype=bool) if held is None else held
    residual, jacobian = linearise(problem, theta, skip=held)
    cost = sum_of_squares(residual)
    exact, settled, slow = True, False, 0
    for _ in range(steps):
        if not np.isfinite(cost):
            break
        step = _step(problem, theta, residual, jacobian, never, damping, tolerance)
        if step is None:
            settled = True
            break
        gained = cost - step.cost
        settled = gained < _least(tolerance, step.cost, problem, len(residual))
        before, theta, residual, cost = (theta, residual), step.theta, step.residual, step.cost
        slow = slow + 1 if goal > 0.0 and gained < _CREEPS * (cost - goal) else 0
        if settled or slow > 1:
            # the Jacobian that predicted so small a step holds at its end, unless damping made it small
            exact = exact and step.damping <= _UNDAMPED and settled
            break
        if gained > _AS_PREDICTED * step.predicted:
            moved = theta - before[0]
            surprise = residual - before[1] - jacobian.change(moved)
            jacobian, exact = jacobian.mended(moved, problem.sizes(before[0]), surprise), False
        else:
            residual, jacobian = linearise(problem, theta, skip=held)
            exact = True
        damping = max(step.damping / 10.0, 1e-9)
    return Minimum(theta, cost, jacobian, exact, settled, slow > 1)


def minimise_fully(
    problem: Problem,
    theta: Array,
    *,
    tolerance: float = 0.02,
    held: Mask | None = None,
    goal: float = 0.0,
) -> Minimum:
    """Lower chi-square until no step is predicted to gain anything by a Jacobian taken there, or it creeps to a `goal`."""
    found = minimise(problem, theta, tolerance=tolerance, held=held, goal=goal)
    for again in range(_CONFIRMATIONS):
        if (found.exact and found.settled) or (found.given_up and (found.exact or again)):
            break
        found = minimise(problem, found.theta, tolerance=tolerance, held=held, goal=goal)
    return found


def _step(
    problem: Problem,
    theta: Array,
    residual: Array,
    jacobian: BlockJacobian,
    never: Mask,
    damping: float,
    tolerance: float,
) -> _Step | None:
    """Find the step that lowers chi-square; None when no step is predicted to gain more than `tolerance`."""
    cost = sum_of_squares(residual)
    least = _least(tolerance, cost, problem, len(residual))
    gradient, normal = jacobian.gradient(residual), jacobian.normal()
    still = never | ((theta <= problem.low) & (gradient > 0)) | ((theta >= problem.high) & (gradient < 0))
    normal[still] = 0.0
    normal[:, still] = 0.0
    diagonal = np.diag(normal)
    # Columns of unit length: no unknown is held back by how well another is known.
    own = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    scaled = normal / np.outer(own, own)
    for _ in range(_TRIALS):
        matrix = scaled + np.diag(np.where(diagonal > 0.0, damping + _SINGULAR, 1.0))
        step = -np.linalg.solve(matrix, np.where(still, 0.0, gradient) / own) / own
        candidate = np.clip(theta + step, problem.low, problem.high)
        predicted = -(2.0 * gradient @ step + step @ normal @ step)
        trial = problem.residuals(candidate)
        trial_cost = sum_of_squares(trial)
        if np.isfinite(trial_cost) and trial_cost < cost:
            return _Step(candidate, trial, trial_cost, float(predicted), damping)
        if predicted < least:
            return None
        damping = max(damping * 8.0, 1e-7)
    return None


def _least(tolerance: float, cost: float, problem: Problem, readings: int) -> float:
    """Return the smallest gain of chi-square that matters: `tolerance` in units of the noise, or of a larger residual.

    That repeats in every reading of a half-cycle.
    """
    half_cycle = np.pi / problem.frequency * problem.windows[0].rate
    return tolerance * float(1.0 + max(cost / readings - _NEAR_FLOOR, 0.0) * half_cycle)


def sum_of_squares(residual: Array) -> float:
    """Return the sum of squares; inf where the motion diverged."""
    size = float(np.max(np.abs(residual), initial=0.0))
    return float(residual @ residual) if size < 1e100 else np.inf
