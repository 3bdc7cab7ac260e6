"""The Hilbert envelope: the older reference beside the wavelet's (Feldman 1997)."""

import numpy as np
from numpy import fft

from identify.arrays import Array


def hilbert_envelope(samples: Array) -> Array:
    """Return the modulus of the analytic signal of `samples` less their mean, shape (n,), ends untreated."""
    n = len(samples)
    spectrum = fft.fft(samples - np.mean(samples))
    one_sided = np.zeros(n)
    one_sided[0] = 1
    one_sided[1 : (n + 1) // 2] = 2
    if n % 2 == 0:
        one_sided[n // 2] = 1
    return np.abs(fft.ifft(spectrum * one_sided))
