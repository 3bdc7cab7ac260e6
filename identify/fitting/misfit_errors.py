"""Standard errors from the actual misfit, not from the noise alone.

Where a model leaves more than noise, its parameters err by what the misfit does where their columns lie: at the
frequency of the motion. There it is a process whose strength and correlation the residual shows; what lies elsewhere
counts as white noise of its mean density. Where several releases differ by more, their spread counts.

The spread of releases: by how much single releases differ in a parameter, beyond what their own misfits explain.

A rig changes between releases, and a law that is not quite right has other constants at other amplitudes. No single
release shows it. Where the values of single releases scatter by more than their errors, the error of all together is
raised by the ratio, as the Particle Data Group averages measurements (Rosenfeld et al., Rev. Mod. Phys. 39, 1, 1967).
"""

from dataclasses import replace

import numpy as np

from identify.arrays import Array, Mask
from identify.fitting.drifting_misfit import CycleSums, cycle_sums, scatter_of_scores
from identify.fitting.fit import Fit
from identify.model.model import Term
from identify.preprocessing.fit_window import FitWindow
from identify.priors import CLEAR

_PRECISE = 3.0
"""Errors above so many times that of the mean, times the root of the number of releases, have no say in the ratio."""

_RANK = 1e-10
_UNDETERMINED = 1e-2
"""Share of a parameter that lies in directions which a release does not determine, from which on it has no say."""


def spread_of_releases(
    windows: tuple[FitWindow, ...], cycles: tuple[CycleSums, ...], scatter: Array, std: Array
) -> Array:
    """Return the factor, 1 at least, by which the spread of releases raises the standard error of each unknown, (p,).

    `cycles` are the sums of all `windows`; `scatter` (windows, p, p) is that of the scores, `std` (p,) the errors from the
    misfit. The value of a single release is that of one Gauss-Newton step from the fit of all.
    """
    release = np.array([window.release for window in windows])
    each = [_alone(cycles, scatter, release == one) for one in np.unique(release)]
    if len(each) < 2:
        return np.ones(len(std))
    values, errors = (np.array(parts) for parts in zip(*each, strict=True))
    counted = np.isfinite(errors) & (errors < _PRECISE * np.sqrt(len(each)) * std)
    weight = np.where(counted, 1.0 / errors**2, 0.0)
    mean = (weight * values).sum(axis=0) / np.maximum(weight.sum(axis=0), 1e-300)
    square = (weight * (values - mean) ** 2).sum(axis=0) / np.maximum(counted.sum(axis=0) - 1, 1)
    return np.asarray(np.sqrt(np.maximum(square, 1.0)))


def _alone(cycles: tuple[CycleSums, ...], scatter: Array, own: Mask) -> tuple[Array, Array]:
    """Return the change of each unknown when only the windows marked `own` count, and its error there, (p,)."""
    p = scatter.shape[1]
    normal, gradient = np.zeros((p, p)), np.zeros(p)
    for one in cycles:
        if own[one.window]:
            normal[np.ix_(one.places, one.places)] += one.products
            gradient[one.places] += np.einsum("pak,ak->p", one.columns, one.residual)
    size = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    values, vectors = np.linalg.eigh(normal / np.outer(size, size))
    seen = values > _RANK * values[-1]
    lost = (vectors[:, ~seen] ** 2).sum(axis=1) > _UNDETERMINED
    inverse = (vectors[:, seen] / values[seen]) @ vectors[:, seen].T / np.outer(size, size)
    variance = np.einsum("ij,jk,ki->i", inverse, scatter[own].sum(axis=0), inverse)
    return -inverse @ gradient, np.where(lost, np.inf, np.sqrt(np.maximum(variance, 1e-300)))


_REACH = 0.5
"""Distance, in units of the motion's frequency, up to which a bin counts."""


def with_misfit_errors(found: Fit) -> Fit:
    """Give a fit the covariance of least squares under its actual misfit, never below that of the noise.

    The sandwich of normal matrix and scatter of the scores (Huber 1967).
    """
    length = np.sqrt(np.diag(found.linearised[1].normal()))
    scales = np.divide(1.0, length, out=np.zeros_like(length), where=length > 0.0)
    cycles, free = cycle_sums(found, scales), np.flatnonzero(scales)
    scatter = scatter_of_scores(cycles, len(free), len(found.windows))
    if scatter is None:  # white noise as dense as the misfit is all that can be said
        return with_covariance(found, found.covariance * max(misfit_density(found), 1.0))
    density, beyond = _density_elsewhere(cycles), scatter.sum(axis=0)
    for one in cycles:
        beyond[np.ix_(one.places, one.places)] -= density * one.products
    own = np.ix_(free, free)
    inverse = found.covariance[own] / np.outer(scales[free], scales[free])
    covariance = inverse * density + inverse @ beyond @ inverse
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    raised = spread_of_releases(found.windows, cycles, scatter, std)
    whole = found.covariance * density
    whole[own] = covariance * np.outer(raised * scales[free], raised * scales[free])
    return with_covariance(found, whole)


def with_covariance(found: Fit, covariance: Array) -> Fit:
    """Replace the covariance of a fit's unknowns; the squares of its standard errors grow by the difference."""
    more = np.diag(covariance) - np.diag(found.covariance)
    stds = [
        float(np.sqrt(max(found.values[u.name].std ** 2 + extra, 0.0)))
        for u, extra in zip(found.unknowns, more, strict=True)
    ]
    values = {
        u.name: replace(found.values[u.name], std=std) for u, std in zip(found.unknowns, stds, strict=True)
    }
    return replace(found, covariance=covariance, values=found.values | values)


def _density_elsewhere(cycles: tuple[CycleSums, ...]) -> float:
    """Return the mean square of the residual off the motion's frequency, in units of the noise; 1 at least."""
    square = sum(one.square - float((one.residual**2).sum()) for one in cycles)
    return max(square / max(sum(one.readings - one.residual.size for one in cycles), 1), 1.0)


def misfit_density(found: Fit, around: float | None = None, channel: str = "") -> float:
    """Estimate the spectral density of the residual around the motion's frequency, in units of that of the noise.

    Or `around` another angular frequency (rad/s), within half the motion's; of one `channel`, or of all.
    """
    power, count = 0.0, 0
    centre = found.frequency if around is None else around
    for i, window in enumerate(found.windows):
        for name in (channel,) if channel else window.channels:
            residual = found.in_noise(name, i)
            spectrum = np.abs(np.fft.rfft(residual)) ** 2 / max(int(window.used[name].sum()), 1)
            omega = np.fft.rfftfreq(len(window), 1.0 / window.rate) * 2.0 * np.pi
            near = np.abs(omega - centre) < _REACH * found.frequency
            power += float(spectrum[near].sum())
            count += int(near.sum())
    return power / max(count, 1)


def is_clear(whole: Fit, term: Term) -> bool:
    """Check whether the strength of an effect differs from zero by some errors of the actual misfit."""
    strength = with_misfit_errors(whole).values[str(term.strength)]
    return bool(np.isfinite(strength.std) and abs(strength.value) > CLEAR * strength.std)
