"""The misfit as a slow random process: its strength, its correlation over cycles, and its effect on parameters.

A fit hides of its misfit what its parameters can follow, which is just what moves them. What is left shows the rest of
the same process, so its strength and correlation are measured by restricted likelihood (Patterson and Thompson 1971),
which knows what was hidden. With few cycles they stay unsure; so the parameters' variance is the mean over all that the
residual allows, and not the variance at the likeliest.

Cycle by cycle: what a residual and the columns of its Jacobian hold at the frequency of the motion.

What a model leaves beyond noise drifts slowly beside the motion, in amplitude and phase. In each cycle of the modelled
motion two numbers hold that, along an orthonormal pair of its cosine and sine; so a record of thousands of readings is
small enough for the correlation of its misfit to be measured.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identify.arrays import Array, Mask
from identify.fitting.fit import Fit
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

    @property
    def products(self) -> Array:
        """The products of the columns with one another, (own, own)."""
        return np.asarray(np.einsum("pak,qak->pq", self.columns, self.columns))


def cycle_sums(found: Fit, scales: Array) -> tuple[CycleSums, ...]:
    """Sum all channels of all windows of a fit cycle by cycle, for steps of its unknowns by `scales` (unknowns,).

    Unknowns whose scale is 0 are left out; places are among the others.
    """
    jacobian, sums = found.linearised[1], []
    among = np.cumsum(scales > 0.0) - 1
    for i, (window, response) in enumerate(
        zip(found.windows, found.problem.responses(found.theta), strict=True)
    ):
        own = scales[jacobian.places[i]] > 0.0
        at, first = jacobian.places[i][own], 0
        for channel in window.channels:
            used = window.used[channel]
            misfit = window.compared(channel, found.residual(channel, i))
            rows = scales[at, None] * jacobian.blocks[i][own, first : first + len(misfit)]
            first += len(misfit)
            summed = _summed(*_rotation(response, found.frequency, used), misfit, rows)
            if summed is not None:
                sums.append(CycleSums(i, among[at], *summed, float(misfit @ misfit), len(misfit)))
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


_TIMES = 6
"""Correlation times that are tried, from one cycle to the longest window."""

_POWERS = (0.0, 1.0)
"""Of the amplitude, in the size of the misfit: another motion beside this one, or a random walk of this one."""

_STRENGTHS = np.concatenate([[0.0], np.geomspace(0.1, 1e6, 9)])
"""Variance of the process in one cycle over that of white noise."""

_BEFORE = np.where(_STRENGTHS > 0.0, 0.5 / (len(_STRENGTHS) - 1), 0.5)
"""Weight of each strength before the residual is seen: white noise has as much as all processes."""

_FEWEST_FREE = 3
"""Numbers beyond the parameters, from which on a variance can be measured."""

_RANK = 1e-10


@dataclass(frozen=True, eq=False)
class _Trial:
    """Processes of one correlation and all strengths: log-likelihoods and variances of the white part, (strengths,) each.

    `process` are the products (own, own) of each one's columns under the process of strength 1.
    """

    likelihood: Array
    variance: Array
    process: list[Array]


def scatter_of_scores(sums: Sequence[CycleSums], p: int, windows: int) -> Array | None:
    """Estimate the covariance of J'e from the residual, by window, in units of the noise, (windows, p, p).

    Of p unknowns, and of what lies at the motion's frequency; e is the misfit before the fit. None where there are too
    few cycles.
    """
    if not sums:
        return None
    longest = max(np.ptp(one.position) for one in sums)
    trials = [
        _trial(sums, p, time, power)
        for power in _POWERS
        for time in np.geomspace(1.0, max(longest, 2.0), _TIMES)
    ]
    likelihood = np.array([trial.likelihood for trial in trials])
    if not np.isfinite(likelihood).any():
        return None
    weight = _BEFORE * np.exp(likelihood - likelihood.max())
    weight /= weight.sum()
    variance = np.array([trial.variance for trial in trials])
    white, process = (weight * np.maximum(variance, 1.0)).sum(), (weight * variance) @ _STRENGTHS
    total = np.zeros((windows, p, p))
    for k, one in enumerate(sums):
        products = white * one.products
        products += sum(share * trial.process[k] for share, trial in zip(process, trials, strict=True))
        total[one.window][np.ix_(one.places, one.places)] += products
    return total


def _trial(sums: Sequence[CycleSums], p: int, time: float, power: float) -> _Trial:
    """Weigh all strengths of a process that keeps for a `time` (cycles), by restricted likelihood over p unknowns."""
    mean = np.sqrt(np.mean(np.concatenate([one.amplitude for one in sums]) ** 2))
    channels = len(sums) / max(len({one.window for one in sums}), 1)
    products, along = np.zeros((len(_STRENGTHS), p, p)), np.zeros((len(_STRENGTHS), p))
    square, determinant = np.zeros(len(_STRENGTHS)), np.zeros(len(_STRENGTHS))
    process = []
    for one in sums:
        scale = (one.amplitude / mean) ** power
        apart = np.sqrt(3.0) * np.abs(np.subtract.outer(one.position, one.position)) / time
        sizes, vectors = np.linalg.eigh((1.0 + apart) * np.exp(-apart) * np.outer(scale, scale))
        sizes = np.maximum(np.tile(sizes, 2), 0.0)
        columns = (one.columns @ vectors).reshape(len(one.places), -1)
        residual = (one.residual @ vectors).ravel()
        process.append(channels * (columns * sizes) @ columns.T)  # channels misfit together
        spread = 1.0 + _STRENGTHS[:, None] * sizes
        weighted = columns / spread[:, None, :]
        products[:, one.places[:, None], one.places] += weighted @ columns.T
        along[:, one.places] += weighted @ residual
        square += (residual**2 / spread).sum(axis=1)
        determinant += np.log(spread).sum(axis=1)
    values, vectors = np.linalg.eigh(products)
    kept = values > _RANK * values[:, -1:]
    followed = np.einsum("qpk,qp->qk", vectors, along) ** 2
    square -= np.divide(followed, values, out=np.zeros_like(values), where=kept).sum(axis=1)
    square = np.maximum(square, 1e-300)
    determinant += np.log(values, out=np.zeros_like(values), where=kept).sum(axis=1)
    left = sum(one.residual.size for one in sums) - kept.sum(axis=1)
    enough = left >= _FEWEST_FREE
    likelihood = np.where(enough, -0.5 * (left * np.log(square) + determinant), -np.inf)
    # raised as the variance of Student's distribution is by few degrees of freedom
    return _Trial(likelihood, np.where(enough, square / np.maximum(left - 2, 1), 1.0), process)
