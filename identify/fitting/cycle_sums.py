"""Cycle by cycle: what a residual and the columns of its Jacobian hold at the frequency of the motion.

What a model leaves beyond noise drifts slowly beside the motion, in amplitude and phase. In each cycle of the modelled
motion two numbers hold that, along an orthonormal pair of its cosine and sine; so a record of thousands of readings is
small enough for the correlation of its misfit to be measured.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identify.arrays import Array, Mask
from identify.fitting.fit import Fit
from identify.fitting.jacobian import linearise
from identify.fitting.problem import Problem
from identify.model.simulate import Response

_FEWEST = 6
"""Readings in a cycle; one with fewer has no say."""

_INDEPENDENT = 0.1
"""Share of a sine's square that must be independent of the cosine, so that a part of a cycle has two numbers."""


@dataclass(frozen=True, eq=False)
class CycleSums:
    """One channel of one window, in units of its noise, cycle by cycle.

    `residual` (2, cycles) along cosine and sine, `columns` (own, 2, cycles) of the Jacobian for the unknowns at `places`
    (own,); `amplitude` (cycles,) is that of the motion times the root of the readings, `position` (cycles,) counts cycles.
    `square` and `readings` are the sum of squares and the number of all readings.
    """

    window: int
    places: NDArray[np.int_]
    residual: Array
    columns: Array
    amplitude: Array
    position: Array
    square: float
    readings: int


def cycle_sums(found: Fit) -> tuple[CycleSums, ...]:
    """Return the sums of all channels of all windows of a fit."""
    problem, sums = Problem(found.model, found.windows, found.frequency), []
    jacobian = linearise(problem, found.theta)[1]
    for i, (window, response) in enumerate(zip(found.windows, problem.responses(found.theta), strict=True)):
        first = 0
        for channel in window.channels:
            used = window.used[channel]
            misfit = window.compared(channel, found.residual(channel, i))
            rows = jacobian.blocks[i][:, first : first + len(misfit)]
            first += len(misfit)
            summed = _summed(*_rotation(response, found.frequency, used), misfit, rows)
            if summed is not None:
                sums.append(CycleSums(i, jacobian.places[i], *summed, float(misfit @ misfit), len(misfit)))
    return tuple(sums)


def _rotation(response: Response, frequency: float, used: Mask) -> tuple[Array, Array]:
    """Return phase (rad) and amplitude of a motion at the readings that are used."""
    quarter = response.velocity / frequency
    phase = np.maximum.accumulate(np.unwrap(np.arctan2(-quarter, response.displacement)))
    return phase[used], np.hypot(response.displacement, quarter)[used]


def _summed(
    phase: Array, amplitude: Array, misfit: Array, rows: Array
) -> tuple[Array, Array, Array, Array] | None:
    """Return residual, columns, amplitude and position of each cycle; None where there is no whole one."""
    if not len(phase) or not np.isfinite(phase).all() or not np.isfinite(misfit).all():
        return None
    turns = (phase - phase[0]) / (2.0 * np.pi)
    starts = np.flatnonzero(np.diff(np.floor(turns), prepend=-1.0))

    def sums(values: Array) -> Array:
        return np.asarray(np.add.reduceat(values, starts, axis=-1))

    cosine, sine = np.cos(phase), np.sin(phase)
    count, cc, cs, ss = sums(np.ones_like(phase)), sums(cosine**2), sums(cosine * sine), sums(sine**2)
    left = ss - cs**2 / np.maximum(cc, 1e-300)
    kept = (count >= _FEWEST) & (left > _INDEPENDENT * ss) & (cc > _INDEPENDENT * ss)
    if not kept.any():
        return None
    root, rest, tilt = np.sqrt(cc[kept]), np.sqrt(left[kept]), (cs / np.maximum(cc, 1e-300))[kept]

    def along(values: Array) -> Array:
        even, odd = sums(values * cosine)[..., kept], sums(values * sine)[..., kept]
        return np.stack([even / root, (odd - tilt * even) / rest], axis=-2)

    size = sums(amplitude)[kept] / np.sqrt(count[kept])
    return along(misfit), along(rows), size, (sums(turns) / count)[kept]
