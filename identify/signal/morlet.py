"""The plain Morlet transform, eq. (7), for pictures."""

import numpy as np
from numpy import fft

from identify.arrays import Array

_COLUMNS = 200


def scalogram(samples: Array, rate: float, frequencies: Array) -> tuple[Array, Array]:
    """Return the modulus of the plain Morlet transform, eq. (7), with one wave a standard deviation, and its times.

    `frequencies` (f,) in Hz. The modulus, shape (f, t), about 200 columns, is scaled so that a steady sine shows its
    amplitude; times (t,) in s.
    """
    n = len(samples)
    length = 1 << (2 * n).bit_length()
    spectrum = fft.fft(samples - np.mean(samples), length)
    axis = fft.fftfreq(length, 1 / rate)
    ratio = axis[None, :] / frequencies[:, None] - 1
    window = np.where(axis[None, :] > 0, 2 * np.exp(-0.5 * (2 * np.pi * ratio) ** 2), 0.0)
    modulus = np.abs(fft.ifft(spectrum * window, axis=1))[:, :n]
    every = max(1, n // _COLUMNS)
    return modulus[:, ::every], np.arange(0, n, every) / rate
