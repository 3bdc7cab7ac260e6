"""Standard errors from the misfit that is there, not from the noise alone.

Where a model leaves more than noise, its parameters err by what the misfit does where their columns lie: at the
frequency of the motion. There it is a process whose strength and correlation the residual shows; what lies elsewhere
counts as white noise of its mean density. Where several releases differ by more, their spread counts.
"""

from dataclasses import replace

import numpy as np

from identify.arrays import Array, Mask
from identify.fitting.cycle_sums import CycleSums, cycle_sums
from identify.fitting.drifting_misfit import scatter_of_scores
from identify.fitting.fit import Fit
from identify.fitting.release_spread import spread_of_releases

_REACH = 0.5
"""Distance, in units of the motion's frequency, up to which a bin counts."""


def with_misfit_errors(found: Fit) -> Fit:
    """Return a fit whose covariance is that of least squares under the misfit that is there; never below the noise's.

    The sandwich of normal matrix and scatter of the scores (Huber 1967).
    """
    free = np.array([u.low < t < u.high for u, t in zip(found.unknowns, found.theta, strict=True)])
    cycles = cycle_sums(found)
    scatter = scatter_of_scores(cycles, free, len(found.windows))
    if scatter is None:
        return as_white_misfit(found)
    inverse = found.covariance[np.ix_(free, free)]
    density = _density_elsewhere(cycles)
    beyond = scatter.sum(axis=0) - density * _products(cycles, free)
    covariance = found.covariance * density
    covariance[np.ix_(free, free)] += inverse @ beyond @ inverse
    std = np.sqrt(np.maximum(np.diag(covariance)[free], 0.0))
    raised = np.ones(len(free))
    raised[free] = spread_of_releases(found.windows, cycles, free, scatter, std)
    covariance *= np.outer(raised, raised)
    return _with_covariance(found, covariance)


def as_white_misfit(found: Fit) -> Fit:
    """Return a fit with the errors that white noise as dense as the misfit around the motion's frequency would leave."""
    return _with_covariance(found, found.covariance * max(misfit_density(found), 1.0))


def _with_covariance(found: Fit, covariance: Array) -> Fit:
    """Return a fit with another covariance of its unknowns, by which the squares of its standard errors grow."""
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
    """Return the mean square of what lies elsewhere than at the motion's frequency, in units of the noise; 1 at least."""
    square = sum(one.square - float((one.residual**2).sum()) for one in cycles)
    return max(square / max(sum(one.readings - one.residual.size for one in cycles), 1), 1.0)


def _products(cycles: tuple[CycleSums, ...], free: Mask) -> Array:
    """Return the products of the free unknowns' columns with one another at the motion's frequency."""
    total = np.zeros((len(free), len(free)))
    for one in cycles:
        total[np.ix_(one.places, one.places)] += np.einsum("pak,qak->pq", one.columns, one.columns)
    return total[np.ix_(free, free)]


def misfit_density(found: Fit, around: float | None = None, channel: str = "") -> float:
    """Return the spectral density of the residual around the motion's frequency, in units of the noise's.

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
