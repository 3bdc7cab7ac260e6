"""The Morlet transform on the ridge, made fair at the ends of a record and across gaps.

Inside the record it is the Morlet transform, eq. (7): the correlation with a Gaussian window times e^{iwt}.
Near an end or a gap half of the window sees nothing, and the plain transform falls off. Here a model
`o + Re[(p + q s) e^{iws}]` (s the time from the window's centre) is fitted under the window by weighted
least squares, with the samples that exist: p is the analytic signal, free of offset, of drift of the envelope
and of the missing half.
"""

from dataclasses import dataclass

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from identify.arrays import Array, Mask

Complex = NDArray[np.complex128]
_REACH = 4.0  # the window is cut at 4 standard deviations, where it is 3e-4


@dataclass(frozen=True, eq=False)
class Ridge:
    """A prepared transform of n samples at one angular frequency (rad/sample).

    The transform is taken at the samples `centres`, shape (c,). `kernels` are the spectra of 1, e^{iws} and
    s e^{iws} under the window, shape (3, m). `solution` turns the five real correlations of a centre into the
    real and imaginary part of p and of q, shape (c, 4, 5). `support` is the share of the window that holds
    samples, shape (c,); `width` is the window's standard deviation in samples.
    """

    n: int
    frequency: float
    width: float
    valid: Mask
    centres: NDArray[np.int_]
    kernels: Complex
    solution: Array
    support: Array
    length: int


def prepare_ridge(valid: Mask, frequency: float, width: float, centres: NDArray[np.int_]) -> Ridge:
    """Prepare the transform at `centres` (c,) of a record whose usable samples are `valid`, shape (n,).

    `frequency` in rad/sample, `width` (the standard deviation of the Gaussian window) in samples.
    """
    n = len(valid)
    reach = int(np.ceil(_REACH * width))
    length = 1 << (n + reach).bit_length()
    offsets = np.arange(-reach, reach + 1)
    window = np.exp(-0.5 * (offsets / width) ** 2)
    s = offsets / width
    wave = np.exp(1j * frequency * offsets)

    # all kernels that are needed: 1, s, s^2 under the window, and those times e^{iws}, e^{2iws}
    plain = window * np.stack([np.ones_like(s), s, s * s])
    stack = np.concatenate([plain + 0j, plain[:2] * wave, plain * wave**2])
    placed = np.zeros((len(stack), length), dtype=np.complex128)
    placed[:, : reach + 1] = stack[:, reach:]
    placed[:, -reach:] = stack[:, :reach]
    spectra = np.conj(fft.fft(placed, axis=1))
    moments = fft.ifft(fft.fft(valid.astype(np.float64), length) * spectra, axis=1)[:, centres]
    m0, m1, m2 = moments[:3].real
    c0, c1, d0, d1, d2 = np.conj(moments[3:])

    normal = np.empty((len(centres), 5, 5))
    normal[:, 0, 0] = m0
    # columns: 1, cos, -sin, s cos, -s sin, so that the unknowns are Re and Im of p and of q
    normal[:, 0, 1], normal[:, 0, 2] = c0.real, -c0.imag
    normal[:, 0, 3], normal[:, 0, 4] = c1.real, -c1.imag
    for row, column, even, double in ((1, 1, m0, d0), (1, 3, m1, d1), (3, 3, m2, d2)):
        normal[:, row, column] = 0.5 * (even + double.real)
        normal[:, row + 1, column + 1] = 0.5 * (even - double.real)
        normal[:, row, column + 1] = -0.5 * double.imag
        normal[:, row + 1, column] = -0.5 * double.imag
    for row in range(5):
        for column in range(row):
            normal[:, row, column] = normal[:, column, row]
    full = float(np.sum(window))
    support = np.asarray(m0 / full, dtype=np.float64)
    normal[:, range(5), range(5)] += 1e-9 * full  # keeps an empty window solvable; its support says so
    solution = np.linalg.inv(normal)[:, 1:, :].astype(np.float64)
    solution[:, 2:] /= width
    kernels = np.conj(spectra[[0, 3, 4]])
    return Ridge(n, frequency, width, valid, centres, kernels, solution, support, length)


def transform(ridge: Ridge, samples: Array) -> tuple[Complex, Complex]:
    """Return the analytic signal p and its local slope q (per sample) at each centre, complex, shape (c,).

    p = A e^{i phi}: the modulus is the envelope, the argument the phase (eq. 8).
    """
    spectrum = fft.fft(np.where(ridge.valid, samples, 0.0), ridge.length)
    plain, wave, drift = fft.ifft(spectrum * np.conj(ridge.kernels), axis=1)[:, ridge.centres]
    right = np.stack([plain.real, wave.real, wave.imag, drift.real, drift.imag], axis=1)
    found = np.einsum("nij,nj->ni", ridge.solution, right)
    return found[:, 0] + 1j * found[:, 1], found[:, 2] + 1j * found[:, 3]


def weights_on_samples(ridge: Ridge, weights: Complex) -> Array:
    """Return the weight of each raw sample in `Re sum_j conj(weights[:, j]) p_j`, shape (r, n).

    The adjoint of `transform`: it carries white noise of the samples into anything linear in p. `weights`
    is complex, shape (r, c).
    """
    spread = weights.real[:, :, None] * ridge.solution[:, 0] + weights.imag[:, :, None] * ridge.solution[:, 1]
    # the correlations are plain.real, (x, cos), (x, -sin), (x, s cos), (x, -s sin)
    rows = np.zeros((len(weights), 3, ridge.length), dtype=np.complex128)
    rows[:, 0, ridge.centres] = spread[:, :, 0]
    rows[:, 1, ridge.centres] = spread[:, :, 1] + 1j * spread[:, :, 2]
    rows[:, 2, ridge.centres] = spread[:, :, 3] + 1j * spread[:, :, 4]
    spectra = fft.fft(rows, axis=2)
    back = fft.ifft(np.sum(spectra * ridge.kernels, axis=1), axis=1)[:, : ridge.n].real
    return np.where(ridge.valid, back, 0.0)


def scalogram(
    samples: Array, rate: float, frequencies: Array, times: int, waves: float
) -> tuple[Array, Array]:
    """Return the modulus of the plain Morlet transform, eq. (7), and the times it stands at.

    `frequencies` (f,) in Hz; about `times` columns; `waves` is w_wavelet / (2 pi), the number of waves in one
    standard deviation. The modulus, shape (f, t), is scaled so that a steady sine shows its amplitude; times (t,) in s.
    """
    n = len(samples)
    length = 1 << (2 * n).bit_length()
    spectrum = fft.fft(samples - np.mean(samples), length)
    axis = fft.fftfreq(length, 1 / rate)
    ratio = axis[None, :] / frequencies[:, None] - 1
    window = np.where(axis[None, :] > 0, 2 * np.exp(-0.5 * (2 * np.pi * waves * ratio) ** 2), 0.0)
    modulus = np.abs(fft.ifft(spectrum * window, axis=1))[:, :n]
    every = max(1, n // times)
    return modulus[:, ::every], np.arange(0, n, every) / rate
