"""The misfit as a process that wanders beside the motion: how strong it is, over how many cycles it keeps, what it does.

A fit hides of its misfit what its parameters can follow, which is just what moves them. What is left shows the rest of
the same process, so its strength and correlation are measured by restricted likelihood (Patterson and Thompson 1971),
which knows what was hidden. With few cycles they stay unsure; so the parameters' variance is the mean over all that the
residual allows, and not the variance at the likeliest.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, Mask
from identify.fitting.cycle_sums import CycleSums

_TIMES = 6
"""Correlation times that are tried, from one cycle to the longest window."""

_POWERS = (0.0, 1.0)
"""Of the amplitude, in the size of the misfit: another motion beside this one, or a wander of this one."""

_STRENGTHS = np.concatenate([[0.0], np.geomspace(0.1, 1e6, 9)])
"""Variance of the process in one cycle over that of white noise."""

_BEFORE = np.where(_STRENGTHS > 0.0, 0.5 / (len(_STRENGTHS) - 1), 0.5)
"""Weight of each strength before the residual is seen: white noise has as much as all processes."""

_FEWEST_FREE = 3
"""Numbers beyond the parameters, from which on a variance can be measured."""

_RANK = 1e-10


@dataclass(frozen=True, eq=False)
class _Trial:
    """Processes of one correlation and all strengths: log-likelihoods and variances, and the products of the columns.

    `white` (p, p) are those under white noise of variance 1, `process` (p, p) those under the process of strength 1, by
    window.
    """

    likelihood: Array
    variance: Array
    white: Array
    process: Array


def scatter_of_scores(sums: Sequence[CycleSums], free: Mask, windows: int) -> Array | None:
    """Return the covariance of J'e that the residual shows, by window, in units of the noise, (windows, p, p).

    Of the p unknowns that are `free`, and of what lies at the motion's frequency; e is the misfit before the fit. None
    where there are too few cycles.
    """
    if not sums:
        return None
    design = [_design(one, free) for one in sums]
    size = np.sqrt(sum((d**2).sum(axis=(1, 2)) for d in design)) + 1e-300
    design = [d / size[:, None, None] for d in design]
    longest = max(np.ptp(one.position) for one in sums)
    trials = [
        _trial(sums, design, time, power, windows)
        for power in _POWERS
        for time in np.geomspace(1.0, max(longest, 2.0), _TIMES)
    ]
    likelihood = np.array([trial.likelihood for trial in trials])
    if not np.isfinite(likelihood).any():
        return None
    weight = _BEFORE * np.exp(likelihood - likelihood.max())
    weight /= weight.sum()
    total = np.zeros((windows, len(size), len(size)))
    for one, trial in zip(weight, trials, strict=True):
        variance = one * trial.variance
        total += (one * np.maximum(trial.variance, 1.0)).sum() * trial.white
        total += (variance @ _STRENGTHS) * trial.process
    return np.asarray(total * np.outer(size, size))


def _design(one: CycleSums, free: Mask) -> Array:
    """Return the columns of the free unknowns, (p, 2, cycles)."""
    full = np.zeros((len(free), *one.columns.shape[1:]))
    full[one.places] = one.columns
    return np.asarray(full[free])


def _trial(
    sums: Sequence[CycleSums], design: Sequence[Array], time: float, power: float, windows: int
) -> _Trial:
    mean = np.sqrt(np.mean(np.concatenate([one.amplitude for one in sums]) ** 2))
    p = design[0].shape[0]
    white, process = np.zeros((windows, p, p)), np.zeros((windows, p, p))
    sizes, left, columns = [], [], []
    channels = len(sums) / max(len({one.window for one in sums}), 1)
    for one, d in zip(sums, design, strict=True):
        scale = (one.amplitude / mean) ** power
        apart = np.sqrt(3.0) * np.abs(np.subtract.outer(one.position, one.position)) / time
        variances, vectors = np.linalg.eigh((1.0 + apart) * np.exp(-apart) * np.outer(scale, scale))
        variances = np.maximum(np.tile(variances, 2), 0.0)
        turned = (d @ vectors).reshape(p, -1)
        white[one.window] += turned @ turned.T
        process[one.window] += channels * (turned * variances) @ turned.T  # channels misfit together
        sizes.append(variances)
        left.append((one.residual @ vectors).ravel())
        columns.append(turned)
    return _Trial(
        *_restricted(np.concatenate(sizes), np.concatenate(left), np.concatenate(columns, axis=1)),
        white,
        process,
    )


def _restricted(sizes: Array, left: Array, columns: Array) -> tuple[Array, Array]:
    """Return restricted log-likelihood and variance of the white part for every strength, (strengths,) each.

    `sizes` (n,) are the eigenvalues of the process, `left` (n,) and `columns` (p, n) are in its eigenvectors. The variance
    is raised as that of Student's distribution is by few degrees of freedom.
    """
    spread = 1.0 + _STRENGTHS[:, None] * sizes
    weighted = columns / spread[:, None, :]
    values, vectors = np.linalg.eigh(weighted @ columns.T)
    kept = values > _RANK * values[:, -1:]
    free = len(left) - kept.sum(axis=1)
    along = np.einsum("qpk,qp->qk", vectors, weighted @ left)
    followed = np.divide(along**2, values, out=np.zeros_like(values), where=kept)
    square = np.maximum((left**2 / spread).sum(axis=1) - followed.sum(axis=1), 1e-300)
    determinant = np.log(spread).sum(axis=1) + np.log(values, out=np.zeros_like(values), where=kept).sum(
        axis=1
    )
    enough = free >= _FEWEST_FREE
    likelihood = np.where(enough, -0.5 * (free * np.log(square) + determinant), -np.inf)
    return likelihood, np.where(enough, square / np.maximum(free - 2, 1), 1.0)
