"""The equation of motion under sliding windows: eq. (15) where its information lies, with noise that is known.

A sample of eq. (15) is mostly noise: differentiation lifts it, while what damping does hides near the natural
frequency. So both sides are summed under short windows `W(s) e^{-iws}` that slide over the record. Every window
gives two rows of the same linear equation (17), in the same unknowns. Because acceleration, velocity and
displacement agree with each other, a displacement noise n enters a row as `sum n (phi'' - mu_1 phi' + k_1 phi)`,
almost nothing at the natural frequency; the covariance of the rows follows, and is banded.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import fft
from scipy.linalg import cholesky_banded, solve_banded
from scipy.signal import savgol_filter

from identify.arrays import Array, Mask

WINDOW_CYCLES = 2.0
ROWS_PER_CYCLE = 4
_JITTER = 1e-4  # of the rows' variance: neighbouring windows share most of their samples
_TAIL = 4  # steps over which coloured noise of two windows that no longer overlap may still agree


@dataclass(frozen=True, eq=False)
class Windows:
    """Windows of one length at starts `first` (w,) samples; `kernel`, `slope`, `curvature` are phi and its derivatives, complex (l,)."""

    first: Array
    step: int
    kernel: Array
    slope: Array
    curvature: Array


def place_windows(valid: Mask, rate: float, angular_frequency: float) -> Windows:
    """Place windows of two cycles, four starts a cycle, wherever all their samples are `valid` (n,)."""
    cycle = 2 * np.pi * rate / angular_frequency
    length = max(8, int(round(WINDOW_CYCLES * cycle)))
    step = max(1, int(round(cycle / ROWS_PER_CYCLE)))
    angle = np.pi * (np.arange(length) + 0.5) / length
    turn = np.pi * rate / length
    window = np.sin(angle) ** 4
    slope = 4 * np.sin(angle) ** 3 * np.cos(angle) * turn
    curvature = (12 * np.sin(angle) ** 2 * np.cos(angle) ** 2 - 4 * np.sin(angle) ** 4) * turn**2
    w = angular_frequency
    wave = np.exp(-1j * w * (np.arange(length) - 0.5 * (length - 1)) / rate)
    lost = np.concatenate([[0], np.cumsum(~valid)])
    first = np.arange(0, max(len(valid) - length + 1, 0), step)
    first = first[lost[first + length] == lost[first]]
    return Windows(
        first,
        step,
        window * wave,
        (slope - 1j * w * window) * wave,
        (curvature - 2j * w * slope - w**2 * window) * wave,
    )


def rows_of(windows: Windows, columns: Array) -> Array:
    """Return the sums of `columns` (p, n) under the windows, real and imaginary parts in turn, shape (2w, p)."""
    views = np.lib.stride_tricks.sliding_window_view(columns, len(windows.kernel), axis=1)
    sums = views[:, windows.first] @ np.stack([windows.kernel.real, windows.kernel.imag], axis=1)
    return sums.transpose(1, 2, 0).reshape(-1, len(columns))


def band_of(windows: Windows, kernel: Array, rate: float, spectrum: Callable[[Array], Array]) -> Array:
    """Return the covariance of the rows for noise summed under `kernel` (l,), in lower banded form.

    `spectrum` gives the variance of a sample by angular frequency (rad/s); white noise is a constant.
    """
    overlap = (len(kernel) - 1) // windows.step + _TAIL
    width = 2 * (overlap + 1)
    length = fft.next_fast_len(2 * (len(kernel) + (_TAIL + 1) * windows.step))
    level = spectrum(np.abs(2 * np.pi * fft.fftfreq(length, 1 / rate)))
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

    `values` (p,) with their `covariance` (p, p); `gain` (p, 2w) carries whitened rows into them; `white` (2w,) are the
    whitened residuals and `chi_square` their mean square over the degrees of freedom.
    """

    values: Array
    gain: Array
    covariance: Array
    white: Array
    degrees: int
    chi_square: float


def solve(rows: Array, right: Array, band: Array) -> LeastSquares:
    """Solve `rows` (m, p) c = `right` (m,) by SVD, weighted by the rows' covariance in lower `band`ed form."""
    band = band.copy()
    band[0] += _JITTER * np.max(band[0])
    factor = cholesky_banded(band, lower=True, check_finite=False)
    white = whiten(factor, np.column_stack([rows, right]))
    scale = np.linalg.norm(white[:, :-1], axis=0) + 1e-300
    left, singular, across = np.linalg.svd(white[:, :-1] / scale, full_matrices=False)
    kept = np.where(singular > 1e-10 * singular[0], 1 / singular, 0.0)
    inverse = (across.T * kept) @ left.T / scale[:, None]
    values = inverse @ white[:, -1]
    residual = white[:, -1] - white[:, :-1] @ values
    degrees = max(1, len(right) - rows.shape[1])
    return LeastSquares(
        values, inverse, inverse @ inverse.T, residual, degrees, float(residual @ residual) / degrees
    )


def whiten(factor: Array, columns: Array) -> Array:
    """Return L^-1 `columns` for the lower banded Cholesky `factor` L."""
    return np.asarray(solve_banded((len(factor) - 1, 0), factor, columns, check_finite=False))


@dataclass(frozen=True, eq=False)
class Direction:
    """The direction of motion between samples: `before` (n - 1,) is sgn v until the share `at` (n - 1,) of each interval."""

    before: Array
    at: Array


def direction_of(velocity: Array, jump: float = 0.0) -> Direction:
    """Return the direction of motion, with each reversal placed between two samples by the straight line.

    `jump` (m/s) is what dry friction's jump of the acceleration does to the velocity within one interval: the line is
    steeper before the reversal than after it.
    """
    before, after = velocity[:-1], velocity[1:]
    turns = before * after < 0
    fall = np.where(turns, before - after, 1.0)
    at = np.where(turns, before / fall, 1.0)
    at = np.clip(at - at * (1 - at) * jump / np.maximum(np.abs(fall), jump + 1e-300), 0.0, 1.0)
    return Direction(np.where(before != 0, np.sign(before), np.sign(after)), at)


def averaged_sign(direction: Direction) -> Array:
    """Return sgn v averaged under the hat of two sampling intervals around each sample, shape (n,).

    So the friction's jump is summed where it fell and not where the next sample is. The second difference makes up for what
    a straight line between the samples of a window misses of it.
    """
    sign, at = direction.before, direction.at
    out = np.zeros(len(sign) + 1)
    out[:-1] += sign * (2 * (at - 0.5 * at**2) - 0.5)
    out[1:] += sign * (at**2 - 0.5)
    out[0] *= 2
    out[-1] *= 2
    out[1:-1] -= (out[2:] - 2 * out[1:-1] + out[:-2]) / 12
    return out


def quieter_velocity(velocity: Array, direction: Direction, dry: float, rate: float, reach: int) -> Array:
    """Return the velocity smoothed over `reach` samples on either side, its kinks at the reversals kept, (n,).

    What dry friction `dry` (m/s^2) has taken is given back first, which leaves nothing to smear; a cubic is fitted
    under each sample, and the friction is taken off again.
    """
    if reach < 2 or len(velocity) < 2 * reach + 1:
        return velocity
    travelled = np.concatenate([[0.0], np.cumsum(direction.before * (2 * direction.at - 1))])
    taken = dry * travelled / rate
    return np.asarray(savgol_filter(velocity + taken, 2 * reach + 1, 3) - taken)
