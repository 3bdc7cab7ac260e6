"""The Jacobian: how the misfit changes with each unknown, by forward differences whose steps are kept from call to call.

A slope need not be known to the noise: what is simulated for it is integrated in longer steps than the motion is.
"""

from dataclasses import dataclass
from math import inf, isfinite, sqrt

import numpy as np

from identify.arrays import Array, Mask
from identify.fitting.block_jacobian import BlockJacobian
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


def linearise(problem: Problem, theta: Array, *, skip: Mask | None = None) -> tuple[Array, BlockJacobian]:
    """Return the misfit (n,) and its Jacobian by forward differences; zero where skipped.

    The problem keeps the steps, each so large that it moves the readings well above rounding and well below the noise.
    """
    responses, parts = problem.responses(theta), problem.misfits(theta)
    expected = problem.off_expected(theta)
    residual = np.concatenate([*parts, *expected])
    jacobian = BlockJacobian.zeros(problem.pattern, [len(part) for part in [*parts, *expected]])
    if not np.isfinite(residual).all():
        return residual, jacobian
    size = problem.sizes(theta)
    problem.steps = np.where(problem.steps > 0.0, problem.steps, _STEP * size)
    starts = [
        _Start(response, part, *_for_slope(problem, theta, i, part))
        for i, (response, part) in enumerate(zip(responses, parts, strict=True))
    ]
    as_shared = _as_shared(problem, skip)
    for j in range(len(theta)):
        if (skip is not None and skip[j]) or j in as_shared:
            continue
        rows = [(i, row) for i, row in jacobian.of_unknown(j) if i < len(parts)]
        for _ in range(_STEP_TRIALS):
            step, changes = _difference(problem, theta, j, {i: starts[i] for i, _ in rows})
            with np.errstate(over="ignore"):
                moved = sqrt(sum(float(c @ c) for c, _ in changes) / len(residual))
            if not _improve_step(problem, j, moved, float(size[j])):
                break
        for (_, row), (change, largest) in zip(rows, changes, strict=True):
            if step == 0.0:  # lost in rounding: nothing moves
                continue
            if largest < _JUMP:
                np.divide(change, step, out=row)
            else:
                np.divide(change, step, out=row, where=np.abs(change) < _JUMP)
    for j, shared in as_shared.items():
        in_all = dict(jacobian.of_unknown(shared))
        for i, row in jacobian.of_unknown(j):
            row[:] = in_all.get(i, 0.0)
    for k, one in enumerate(problem.expected):
        if skip is None or not skip[one.own]:
            dict(jacobian.of_unknown(one.own))[len(parts)][k] = 1.0 / one.std
    return residual, jacobian


def _as_shared(problem: Problem, skip: Mask | None) -> dict[int, int]:
    """Find the unknowns that change their windows as a shared one does, so only that is differentiated; with its place."""
    places = {one.own: one.shared for one in problem.expected}
    return {j: at for j, at in places.items() if skip is None or not (skip[j] or skip[at])}


def _improve_step(problem: Problem, j: int, moved: float, size: float) -> bool:
    """Adapt the step of unknown j to the rms change that it made; return whether the difference must be repeated."""
    wanted = _READABLE / moved if moved > 0.0 else inf
    before = float(problem.steps[j])
    step = before * min(max(wanted, 1.0 / _STEP_GROWTH), _STEP_GROWTH)
    problem.steps[j] = min(max(step, 1e-12 * size), _LONGEST_STEP * size)
    return not 0.03 < problem.steps[j] / before < 30.0


@dataclass(frozen=True, eq=False)
class _Start:
    """Where differences are taken from in one window: its motion and misfit (n,) followed to the noise, and as for a slope.

    For that it is integrated in so many `substeps` a sample, with `rough` as its misfit (n,).
    """

    response: Response
    misfit: Array
    substeps: int
    rough: Array


def _for_slope(problem: Problem, theta: Array, i: int, misfit: Array) -> tuple[int, Array]:
    """Choose the steps a sample in which window i is integrated for a slope, and return its misfit (n,) with them.

    Where a motion diverges in longer steps, they are as short as the motion needs.
    """
    whole, fewer = problem.substeps(theta, i), problem.substeps(theta, i, tangent=True)
    if fewer < whole:
        rough = problem.residual_of(i, problem.read(theta, i, problem.respond(theta, i, fewer)))
        if np.isfinite(rough).all():
            return fewer, rough
    return whole, misfit


def _difference(
    problem: Problem, theta: Array, j: int, starts: dict[int, _Start]
) -> tuple[float, list[tuple[Array, float]]]:
    """Return the step taken in unknown j, and the change of the misfit of each window of `starts`, (n,).

    With each comes its largest value; what is not finite counts as no change.
    """
    unknown, here, size = problem.unknowns[j], theta[j], problem.steps[j]
    away = -size if here < 0.0 else size  # from zero: alike where a motion is turned over
    moved = theta.copy()
    moved[j] += away if problem.low[j] <= here + away <= problem.high[j] else -away
    step = float(moved[j] - here)
    changes = []
    for i, start in starts.items():
        response, part = start.response, start.misfit
        if unknown.simulated:
            response, part = problem.respond(moved, i, start.substeps), start.rough
        elif j == problem.layout.releases[i].lag:
            response = Response(
                response.displacement - step * response.velocity,
                response.velocity - step * response.acceleration,
                response.acceleration,
            )
        change = problem.residual_of(i, problem.read(moved, i, response)) - part
        largest = float(np.abs(change).max(initial=0.0))
        if not isfinite(largest):
            change = np.where(np.isfinite(change), change, 0.0)
        changes.append((change, largest))
    return step, changes
