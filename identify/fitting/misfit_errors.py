"""Standard errors from the misfit that is there, not from the noise alone.

Where a model leaves more than noise, its parameters err by what the misfit does at the frequency of the motion, where
their columns lie. The variance is that of white noise of the spectral density that the residual has around it.
"""

from dataclasses import replace

import numpy as np

from identify.fitting.fit import Fit

_BAND = (0.5, 1.5)


def with_misfit_errors(found: Fit) -> Fit:
    """Return a fit whose covariance counts the misfit as noise; the same where only noise is left."""
    factor = misfit_density(found)
    if factor <= 1.0:
        return found
    return replace(
        found,
        covariance=found.covariance * factor,
        values={
            name: replace(value, std=float(value.std * np.sqrt(factor)))
            for name, value in found.values.items()
        },
    )


def misfit_density(found: Fit) -> float:
    """Return the spectral density of the residual around the motion's frequency, in units of the noise's."""
    power, count = 0.0, 0
    for i, window in enumerate(found.windows):
        for channel in window.channels:
            residual = found.in_noise(channel, i)
            spectrum = np.abs(np.fft.rfft(residual)) ** 2 / max(int(window.used[channel].sum()), 1)
            ratio = np.fft.rfftfreq(len(window), 1.0 / window.rate) * 2.0 * np.pi / found.frequency
            near = (ratio > _BAND[0]) & (ratio < _BAND[1])
            power += float(spectrum[near].sum())
            count += int(near.sum())
    return power / max(count, 1)
