"""The spread of releases: by how much single releases differ in a parameter, beyond what their own misfits explain.

A rig changes between releases, and a law that is not quite right has other constants at other amplitudes. No single
release shows it. Where the values of single releases scatter by more than their errors, the error of all together is
raised by the ratio, as the Particle Data Group averages measurements (Rosenfeld et al., Rev. Mod. Phys. 39, 1, 1967).
"""

import numpy as np

from identify.arrays import Array, Mask
from identify.fitting.cycle_sums import CycleSums
from identify.preprocessing.fit_window import FitWindow

_PRECISE = 3.0
"""Errors above so many times that of the mean, times the root of the number of releases, have no say in the ratio."""

_RANK = 1e-10
_UNDETERMINED = 1e-2
"""Share of a parameter that lies in directions which a release does not determine, from which on it has no say."""


def spread_of_releases(
    windows: tuple[FitWindow, ...], cycles: tuple[CycleSums, ...], free: Mask, scatter: Array, std: Array
) -> Array:
    """Return by how much the standard error of each free unknown is raised, 1 at least, (p,).

    `cycles` are the sums of all `windows`; `scatter` (windows, p, p) is that of the scores, `std` (p,) the errors from the
    misfit. The value of a single release is that of one Gauss-Newton step from the fit of all.
    """
    release = np.array([window.release for window in windows])
    each = [_alone(cycles, free, scatter, release == one) for one in np.unique(release)]
    if len(each) < 2:
        return np.ones(len(std))
    values, errors = (np.array(parts) for parts in zip(*each, strict=True))
    counted = np.isfinite(errors) & (errors < _PRECISE * np.sqrt(len(each)) * std)
    weight = np.where(counted, 1.0 / errors**2, 0.0)
    mean = (weight * values).sum(axis=0) / np.maximum(weight.sum(axis=0), 1e-300)
    square = (weight * (values - mean) ** 2).sum(axis=0) / np.maximum(counted.sum(axis=0) - 1, 1)
    return np.asarray(np.sqrt(np.maximum(square, 1.0)))


def _alone(cycles: tuple[CycleSums, ...], free: Mask, scatter: Array, own: Mask) -> tuple[Array, Array]:
    """Return by how much each free unknown moves where only the windows marked `own` count, and its error there, (p,)."""
    p = len(free)
    normal, gradient = np.zeros((p, p)), np.zeros(p)
    for one in cycles:
        if own[one.window]:
            normal[np.ix_(one.places, one.places)] += np.einsum("pak,qak->pq", one.columns, one.columns)
            gradient[one.places] += np.einsum("pak,ak->p", one.columns, one.residual)
    normal, gradient = normal[np.ix_(free, free)], gradient[free]
    size = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    values, vectors = np.linalg.eigh(normal / np.outer(size, size))
    seen = values > _RANK * values[-1]
    lost = (vectors[:, ~seen] ** 2).sum(axis=1) > _UNDETERMINED
    inverse = (vectors[:, seen] / values[seen]) @ vectors[:, seen].T / np.outer(size, size)
    variance = np.einsum("ij,jk,ki->i", inverse, scatter[own].sum(axis=0), inverse)
    return -inverse @ gradient, np.where(lost, np.inf, np.sqrt(np.maximum(variance, 1e-300)))
