"""The equation of motion under sliding windows: eq. (15) where its information lies, with noise that is known.

A sample of eq. (15) is mostly noise: differentiation lifts it, while what damping does hides near the natural
frequency. So both sides are summed under short windows `W(s) e^{-iws}` that slide over the record. Every window
gives two rows of the same linear equation (17), in the same unknowns. A window phi vanishes smoothly at its ends, so
`sum phi u'' = sum phi'' u`: where acceleration, velocity and displacement agree with each other, all three are read off
the displacement. Its noise n enters a row as `sum n (phi'' - mu_1 phi' + k_1 phi)`, almost nothing at the natural
frequency; the covariance of the rows follows, and is banded.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from identify.algebra import banded_cholesky
from identify.arrays import Array, Mask
from identify.signal.harmonic_windows import Complex

WINDOW_CYCLES = 2.0
ROWS_PER_CYCLE = 4
_JITTER = 1e-4  # of the rows' variance: neighbouring windows share most of their samples
_TAIL = 4  # steps over which coloured noise of two windows that no longer overlap may still agree


_WAVES = ((0, 3 / 8), (1, -1 / 4), (-1, -1 / 4), (2, 1 / 16), (-2, 1 / 16))
"""W = sin^4 as a sum of exponentials: turns over the length of the window, and their shares."""


@dataclass(frozen=True, eq=False)
class Windows:
    """Windows of `length` samples that start at samples `first` (w,), multiples of `step`.

    `turn` is the angular frequency in rad/sample, `rate` in Hz. The window times its wave is five exponentials.
    """

    first: NDArray[np.int_]
    step: int
    length: int
    turn: float
    rate: float

    def derivative(self, order: int) -> Complex:
        """Return phi, or a derivative of it, at the window's samples, per s^order, shape (l,)."""
        run = np.arange(self.length) + 0.5
        return self._sum(lambda beta: (1j * beta * self.rate) ** order * np.exp(1j * beta * run))

    def integral(self, place: Array) -> Complex:
        """Return the integral of phi from its start to `place` (samples from the window's first), any shape."""
        run = place + 0.5
        return self._sum(lambda beta: run * np.exp(0.5j * beta * run) * np.sinc(beta * run / (2 * np.pi)))

    def _sum(self, part: Callable[[float], Complex]) -> Complex:
        parts = [share * part(2 * np.pi * wave / self.length - self.turn) for wave, share in _WAVES]
        return np.asarray(np.sum(parts, axis=0) * np.exp(0.5j * self.turn * self.length))


def place_windows(valid: Mask, rate: float, angular_frequency: float) -> Windows:
    """Place windows of two cycles, four starts a cycle, wherever all their samples are `valid` (n,)."""
    cycle = 2 * np.pi * rate / angular_frequency
    length = max(8, round(WINDOW_CYCLES * cycle))
    step = max(1, round(cycle / ROWS_PER_CYCLE))
    lost = np.concatenate([[0], np.cumsum(~valid)])
    first = np.arange(0, max(len(valid) - length + 1, 0), step)
    first = first[lost[first + length] == lost[first]]
    return Windows(first, step, length, angular_frequency / rate, rate)


def rows_of(windows: Windows, kernel: Complex, columns: Array) -> Array:
    """Return the sums of `columns` (p, n) under `kernel` (l,), real and imaginary parts in turn, shape (2w, p)."""
    views = np.lib.stride_tricks.sliding_window_view(columns, len(kernel), axis=1)
    sums = views[:, windows.first] @ np.stack([kernel.real, kernel.imag], axis=1)
    return sums.transpose(1, 2, 0).reshape(-1, len(columns))


def band_of(windows: Windows, kernel: Complex, spectrum: Callable[[Array], Array]) -> Array:
    """Return the covariance of the rows for noise summed under `kernel` (l,), in lower banded form.

    `spectrum` gives the variance of a sample by angular frequency (rad/s); white noise is a constant.
    """
    overlap = (len(kernel) - 1) // windows.step + _TAIL
    width = 2 * (overlap + 1)
    length = 1 << (2 * (len(kernel) + (_TAIL + 1) * windows.step)).bit_length()
    level = spectrum(np.abs(2 * np.pi * fft.fftfreq(length, 1 / windows.rate)))
    parts = (fft.fft(kernel.real, length), fft.fft(kernel.imag, length))
    apart = np.arange(overlap + 1) * windows.step
    # shared[a, b, d]: covariance of part a of a window with part b of the window d steps later
    shared = np.array(
        [[fft.ifft(np.conj(a) * b * level).real[-apart % length] for b in parts] for a in parts]
    )
    n = 2 * len(windows.first)
    band = np.zeros((width, n))
    for later in range(min(overlap + 1, len(windows.first))):
        distance = (windows.first[later:] - windows.first[: len(windows.first) - later]) // windows.step
        near = distance <= overlap
        for a in range(2):
            for b in range(2):
                offset = 2 * later + b - a
                if 0 <= offset < width:
                    values = np.where(near, shared[a, b, np.minimum(distance, overlap)], 0.0)
                    band[offset, a : a + 2 * len(values) : 2] = values
    return band


@dataclass(frozen=True, eq=False)
class LeastSquares:
    """Solution of weighted rows.

    `values` (p,) with their `covariance` (p, p); `gain` (p, 2w) carries whitened rows into the values; `white` (2w,) are
    the whitened residuals and `chi_square` their mean square over the degrees of freedom.
    """

    values: Array
    gain: Array
    covariance: Array
    white: Array
    chi_square: float


def factor_of(band: Array) -> Array:
    """Return the banded Cholesky factor of the rows' covariance."""
    raised = band.copy()
    raised[0] += _JITTER * np.max(band[0])
    return banded_cholesky(raised)


def solve(white: Array, right: Array) -> LeastSquares:
    """Solve whitened rows (m, p) c = `right` (m,) by SVD, as the paper does eq. (17)."""
    scale = np.linalg.norm(white, axis=0) + 1e-300
    inverse = np.linalg.pinv(white / scale, rcond=1e-10) / scale[:, None]
    values = inverse @ right
    residual = right - white @ values
    degrees = max(1, len(right) - white.shape[1])
    return LeastSquares(values, inverse, inverse @ inverse.T, residual, float(residual @ residual) / degrees)
