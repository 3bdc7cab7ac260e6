"""Standard errors from the misfit that is there, not from the noise alone.

Where a model leaves more than noise, its parameters err by what the misfit does at the frequency of the motion, where
their columns lie. The variance is that of white noise of the spectral density that the residual has around it.
"""

from dataclasses import replace

import numpy as np

from identify.fitting.fit import Fit

_REACH = 0.5
"""Distance, in units of the motion's frequency, up to which a bin counts."""


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
