"""The covariance of parameters: from noise, and from a misfit."""

import numpy as np

from identify.algebra import recursion
from identify.arrays import Array

_SURE = 3.0  # standard deviations by which a misfit must exceed the noise before it counts


def misfit_covariance(residual: Array, gain: Array, independent: float, parameters: int) -> Array:
    """Return the covariance that a model's misfit adds to its parameters, shape (p, p), zero when there is none.

    `residual` (m,) is what the model leaves of the observations, in standard deviations of their noise;
    `gain` (p, m) carries the observations, in the same measure, into the parameters asked for, of
    `parameters` fitted in all;
    `independent` is the number of independent observations among the m under noise alone. A misfit is
    correlated over longer stretches than noise: its length is read off its own autocorrelation, which is taken to fall off
    exponentially.
    """
    free = max(1.0, independent - parameters)
    ratio = float(np.mean(residual**2)) * independent / free
    if ratio <= 1 + _SURE * np.sqrt(2 / free):
        return np.zeros((len(gain), len(gain)))
    centred = residual - np.mean(residual)
    m = len(centred)
    spectrum = np.abs(np.fft.rfft(centred, 2 * m)) ** 2
    autocorrelation = np.fft.irfft(spectrum)[:m]
    autocorrelation = autocorrelation / max(autocorrelation[0], 1e-300)
    short = np.flatnonzero(autocorrelation < np.exp(-1))
    length = float(max(short[0] if len(short) else m, m / independent / 3.5))
    stretches = max(m / (2 * length), parameters + 1.0)
    variance = float(np.mean(residual**2)) * stretches / (stretches - parameters)
    # the exponential's product with a row is one recursion forwards and one backwards
    fade = float(np.exp(-1 / length))
    forwards = recursion(gain.T, fade).T
    backwards = recursion(gain.T[::-1], fade)[::-1].T
    return np.asarray(variance * (forwards + backwards - gain) @ gain.T)
