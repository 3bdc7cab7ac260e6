"""The Jacobian: how the misfit changes with each unknown, by forward differences whose steps are kept from call to call.

A slope need not be known to the noise: what is simulated for it is integrated in longer steps than the motion is.
"""

from math import inf, sqrt

import numpy as np

from identify.arrays import Array, Mask
from identify.fitting.block_jacobian import BlockJacobian
from identify.fitting.problem import Problem, Simulated
from identify.model.simulate import Response

_STEP = 1e-5
_STEP_TRIALS = 4
_STEP_GROWTH = 1e3
_LONGEST_STEP = 1e-2
JUMP = 0.5
"""Change of a reading by a small step, in units of the noise, from which on a reversal has crossed its sample."""

_READABLE = 3e-3
"""Root mean square change of the readings, in units of the noise, at which a difference is taken."""


def linearise(problem: Problem, theta: Array, *, skip: Mask | None = None) -> tuple[Array, BlockJacobian]:
    """Return the misfit (n,) and its Jacobian by forward differences; zero where skipped.

    The problem keeps the steps, each so large that it moves the readings well above rounding and well below the noise.
    """
    motions = problem.motions(theta)
    parts = [*(motion.misfit for motion in motions), *problem.off_expected(theta)]
    residual = np.concatenate(parts)
    jacobian = BlockJacobian.zeros(problem.pattern, [len(part) for part in parts])
    if not np.isfinite(residual).all():
        return residual, jacobian
    size = problem.sizes(theta)
    problem.steps = np.where(problem.steps > 0.0, problem.steps, _STEP * size)
    starts = [(motion, *_for_slope(problem, theta, i, motion.misfit)) for i, motion in enumerate(motions)]
    wanted = np.ones(len(theta), dtype=bool) if skip is None else ~skip
    # What changes its windows as a shared unknown does has the columns of that.
    as_shared = {j for j in problem.expected if wanted[j] and wanted[problem.unknowns[j].deviates]}
    for j in np.flatnonzero(wanted).tolist():
        if j in as_shared:
            continue
        rows = [(i, row) for i, row in jacobian.of_unknown(j) if i < len(motions)]
        for _ in range(_STEP_TRIALS):
            step, changes = _difference(problem, theta, j, {i: starts[i] for i, _ in rows})
            with np.errstate(over="ignore"):
                moved = sqrt(sum(float(c @ c) for c in changes) / len(residual))
            if not _improve_step(problem, j, moved, float(size[j])):
                break
        for (_, row), change in zip(rows, changes, strict=True):
            if step != 0.0:  # else it is lost in rounding: nothing moves
                np.divide(change, step, out=row, where=np.abs(change) < JUMP)
    for k, j in enumerate(problem.expected):
        *own, (_, off) = jacobian.of_unknown(j)
        if j in as_shared:
            in_all = dict(jacobian.of_unknown(problem.unknowns[j].deviates))
            for i, row in own:
                row[:] = in_all[i]
        if wanted[j]:
            off[k] = 1.0 / problem.unknowns[j].std
    return residual, jacobian


def _improve_step(problem: Problem, j: int, moved: float, size: float) -> bool:
    """Adapt the step of unknown j to the rms change that it made; return whether the difference must be repeated."""
    wanted = _READABLE / moved if moved > 0.0 else inf
    before = float(problem.steps[j])
    step = before * min(max(wanted, 1.0 / _STEP_GROWTH), _STEP_GROWTH)
    problem.steps[j] = min(max(step, 1e-12 * size), _LONGEST_STEP * size)
    return not 0.03 < problem.steps[j] / before < 30.0


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
    problem: Problem, theta: Array, j: int, starts: dict[int, tuple[Simulated, int, Array]]
) -> tuple[float, list[Array]]:
    """Return the step taken in unknown j, and the change of the misfit of each window of `starts`, (n,).

    Those are motions followed to the noise, each with the steps a sample for a slope and the misfit with them. What is not
    finite counts as no change.
    """
    unknown, here, size = problem.unknowns[j], theta[j], problem.steps[j]
    away = -size if here < 0.0 else size  # from zero: alike where a motion is turned over
    moved = theta.copy()
    moved[j] += away if problem.low[j] <= here + away <= problem.high[j] else -away
    step = float(moved[j] - here)
    changes = []
    for i, (motion, substeps, rough) in starts.items():
        response, part = motion.response, motion.misfit
        if unknown.simulated:
            response, part = problem.respond(moved, i, substeps), rough
        elif j == problem.layout.releases[i].lag:
            response = Response(
                response.displacement - step * response.velocity,
                response.velocity - step * response.acceleration,
                response.acceleration,
            )
        change = problem.residual_of(i, problem.read(moved, i, response)) - part
        changes.append(np.where(np.isfinite(change), change, 0.0))
    return step, changes
