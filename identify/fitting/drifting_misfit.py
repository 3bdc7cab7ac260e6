"""The misfit as a process that drifts beside the motion: how strong it is, over how many cycles it keeps, what it does.

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


def cycle_sums(found: Fit) -> tuple[CycleSums, ...]:
    """Return the sums of all channels of all windows of a fit."""
    jacobian, sums = found.linearised[1], []
    for i, (window, response) in enumerate(
        zip(found.windows, found.problem.responses(found.theta), strict=True)
    ):
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
class _Columns:
    """Columns of the Jacobian in one channel of one window, of unit length over all.

    `values` (own, 2, cycles) of those free unknowns that move it; `places` (own,) are theirs among the p free ones.
    """

    places: NDArray[np.int_]
    values: Array


@dataclass(frozen=True, eq=False)
class _Trial:
    """Processes of one correlation and all strengths: log-likelihoods and variances of the white part, (strengths,) each.

    `process` are the products (own, own) of each one's columns under the process of strength 1.
    """

    likelihood: Array
    variance: Array
    process: tuple[Array, ...]


def scatter_of_scores(sums: Sequence[CycleSums], free: Mask, windows: int) -> Array | None:
    """Return the covariance of J'e that the residual shows, by window, in units of the noise, (windows, p, p).

    Of the p unknowns that are `free`, and of what lies at the motion's frequency; e is the misfit before the fit. None
    where there are too few cycles.
    """
    if not sums:
        return None
    design, size = _design(sums, free)
    longest = max(np.ptp(one.position) for one in sums)
    trials = [
        _trial(sums, design, len(size), time, power)
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
    total = np.zeros((windows, len(size), len(size)))
    for k, (one, own) in enumerate(zip(sums, design, strict=True)):
        products = white * np.einsum("pak,qak->pq", own.values, own.values)
        products += sum(share * trial.process[k] for share, trial in zip(process, trials, strict=True))
        total[one.window][np.ix_(own.places, own.places)] += products
    return np.asarray(total * np.outer(size, size))


def _design(sums: Sequence[CycleSums], free: Mask) -> tuple[list[_Columns], Array]:
    """Return the columns of the free unknowns in each, and the lengths (p,) by which they were divided."""
    among = np.cumsum(free) - 1
    found = [_Columns(among[one.places[free[one.places]]], one.columns[free[one.places]]) for one in sums]
    square = np.zeros(int(free.sum()))
    for own in found:
        square[own.places] += (own.values**2).sum(axis=(1, 2))
    size = np.sqrt(square) + 1e-300
    return [_Columns(own.places, own.values / size[own.places, None, None]) for own in found], size


@dataclass(frozen=True, eq=False)
class _Turned:
    """One channel of one window in the eigenvectors of a process, whose eigenvalues are `sizes` (n,).

    `left` (n,) is what is left, `columns` (own, n) those of the unknowns at `places` (own,) among all.
    """

    sizes: Array
    left: Array
    places: NDArray[np.int_]
    columns: Array


def _trial(
    sums: Sequence[CycleSums], design: Sequence[_Columns], p: int, time: float, power: float
) -> _Trial:
    mean = np.sqrt(np.mean(np.concatenate([one.amplitude for one in sums]) ** 2))
    turned, process = [], []
    channels = len(sums) / max(len({one.window for one in sums}), 1)
    for one, own in zip(sums, design, strict=True):
        scale = (one.amplitude / mean) ** power
        apart = np.sqrt(3.0) * np.abs(np.subtract.outer(one.position, one.position)) / time
        variances, vectors = np.linalg.eigh((1.0 + apart) * np.exp(-apart) * np.outer(scale, scale))
        variances = np.maximum(np.tile(variances, 2), 0.0)
        columns = (own.values @ vectors).reshape(len(own.places), -1)
        process.append(channels * (columns * variances) @ columns.T)  # channels misfit together
        turned.append(_Turned(variances, (one.residual @ vectors).ravel(), own.places, columns))
    return _Trial(*_restricted(turned, p), tuple(process))


def _restricted(turned: Sequence[_Turned], p: int) -> tuple[Array, Array]:
    """Return restricted log-likelihood and variance of the white part for every strength, (strengths,) each.

    Of p unknowns in all. The variance is raised as that of Student's distribution is by few degrees of freedom.
    """
    count = len(_STRENGTHS)
    products, along = np.zeros((count, p, p)), np.zeros((count, p))
    square, determinant = np.zeros(count), np.zeros(count)
    for one in turned:
        spread = 1.0 + _STRENGTHS[:, None] * one.sizes
        weighted = one.columns / spread[:, None, :]
        products[:, one.places[:, None], one.places] += weighted @ one.columns.T
        along[:, one.places] += weighted @ one.left
        square += (one.left**2 / spread).sum(axis=1)
        determinant += np.log(spread).sum(axis=1)
    values, vectors = np.linalg.eigh(products)
    kept = values > _RANK * values[:, -1:]
    free = sum(len(one.left) for one in turned) - kept.sum(axis=1)
    turned_along = np.einsum("qpk,qp->qk", vectors, along)
    followed = np.divide(turned_along**2, values, out=np.zeros_like(values), where=kept)
    square = np.maximum(square - followed.sum(axis=1), 1e-300)
    determinant += np.log(values, out=np.zeros_like(values), where=kept).sum(axis=1)
    enough = free >= _FEWEST_FREE
    likelihood = np.where(enough, -0.5 * (free * np.log(square) + determinant), -np.inf)
    return likelihood, np.where(enough, square / np.maximum(free - 2, 1), 1.0)
