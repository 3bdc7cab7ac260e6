"""Cycle by cycle: how much faster the measured motion is than the model, and how much more energy it loses."""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, frozen
from identify.comparison.multiple_shooting import MultipleShooting
from identify.comparison.residual_force import nuisances, respond_in

_STUCK = 1e-12
"""Smallest singular value, of the largest, of what a force does to a cycle's end: where the mass sticks, nothing."""

_SHARE = 0.01


@dataclass(frozen=True, eq=False)
class CycleErrors:
    """Errors of the model in every cycle, measured less model, each of shape (cycles,).

    `time` (s since the release) and `amplitude` (m) of the middle of each cycle. `frequency_error` in % of the
    frequency, positive when the measured motion is faster (stiffer); `energy_error` in J per kg and cycle, positive when
    the measured motion loses more (more damping). `covariance` (2 cycles, 2 cycles) is that of both,
    frequency first; `chi_square_after` is the reduced chi-square that such changes would leave.
    """

    time: Array
    amplitude: Array
    frequency_error: Array
    frequency_error_std: Array
    energy_error: Array
    energy_error_std: Array
    covariance: Array
    chi_square_after: float


def compare_cycles(shooting: MultipleShooting) -> CycleErrors:
    """Return the errors of the tracked model in every cycle.

    The state at the start of each cycle is found from the readings around it; in between, a change of stiffness
    and one of viscous damping make the model arrive where the next cycle begins. All cycles are solved at once,
    with lag, gain and offset of the acceleration as common unknowns. Where the mass stands still nothing is known: the
    error is as large as the spring, and as the energy of the largest cycle.
    """
    window, segments, count = shooting.window, shooting.segments, len(shooting.segments)
    normal, gradient, turn, fixed, left, per_energy = _assemble(shooting)
    scale = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    both = np.outer(scale, scale)
    inverse = np.linalg.pinv(normal / both, hermitian=True) / both
    left -= float(gradient @ inverse @ gradient)
    kappa = turn @ (inverse @ gradient) + fixed
    factors = np.concatenate([np.full(count, 50.0 * _SHARE), per_energy])
    order = np.r_[0 : 2 * count : 2, 1 : 2 * count : 2]
    errors = factors * kappa[order]
    covariance = (turn @ inverse @ turn.T)[np.ix_(order, order)] * np.outer(factors, factors)
    whole = np.repeat([factors[0], np.max(per_energy)], count) / _SHARE
    covariance += np.diag(np.where(np.diag(covariance) > 0.0, 0.0, whole**2))
    std = np.sqrt(np.diag(covariance))
    sweep = np.hypot(shooting.displacement, shooting.velocity / shooting.frequency)
    return CycleErrors(
        frozen([window.time + 0.5 * (s.start + s.stop) / window.rate for s in segments]),
        frozen([float(np.mean(sweep[s.start : s.stop])) for s in segments]),
        frozen(errors[:count]),
        frozen(std[:count]),
        frozen(errors[count:]),
        frozen(std[count:]),
        frozen(covariance),
        left / max(len(shooting.misfit) - len(gradient), 1),
    )


def _assemble(shooting: MultipleShooting) -> tuple[Array, Array, Array, Array, float, Array]:
    """Return the normal equations of the states at the cycles' starts and of the common unknowns, and what the states mean.

    The changes of stiffness and damping are `turn` (2 cycles, unknowns) times the unknowns plus `fixed` (2 cycles,);
    `left` is the misfit before they are solved, `per_energy` (cycles,) the energy that a unit of damping takes a cycle.
    """
    segments, omega, common = shooting.segments, shooting.frequency, nuisances(shooting)
    count, extra = len(segments), common.shape[1]
    unknowns = 2 * (count + 1) + extra
    normal, gradient = np.zeros((unknowns, unknowns)), np.zeros(unknowns)
    turn, fixed = np.zeros((2 * count, unknowns)), np.zeros(2 * count)
    left, per_energy = 0.0, np.zeros(count)
    for j, segment in enumerate(segments):
        until = segments[j + 1].begin if j + 1 < count else segment.stop - 1
        part = slice(segment.begin, segment.stop)
        u, v = shooting.displacement[part], shooting.velocity[part]
        patterns = _SHARE * np.column_stack([shooting.stiffness * u, omega * v])
        response, end = respond_in(shooting, segment, patterns, until)
        inverse = np.linalg.pinv(end, rcond=_STUCK)
        gap = segments[j + 1].departure - segment.arrival if j + 1 < count else np.zeros(2)
        columns = np.hstack(
            [
                segment.variation - response @ (inverse @ segment.carry),
                response @ inverse,
                common[segment.rows],
            ]
        )
        rest = shooting.misfit[segment.rows] - response @ (inverse @ gap)
        places = np.r_[2 * j : 2 * j + 4, unknowns - extra : unknowns]
        normal[np.ix_(places, places)] += columns.T @ columns
        gradient[places] += columns.T @ rest
        left += float(rest @ rest)
        turn[2 * j : 2 * j + 2, 2 * j : 2 * j + 2] = -inverse @ segment.carry
        turn[2 * j : 2 * j + 2, 2 * j + 2 : 2 * j + 4] = inverse
        fixed[2 * j : 2 * j + 2] = inverse @ gap
        per_energy[j] = _SHARE * omega * np.mean(v**2) * 2.0 * np.pi / omega
    return normal, gradient, turn, fixed, left, per_energy
