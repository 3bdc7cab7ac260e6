"""Kinematics: the relation of two channels of one motion, whatever the forces are.

With u the lower channel (displacement, or velocity) and a the higher one (acceleration), the samples obey
    N a = g H u + N d + noise,
where H is a difference of order 2 (or 1) read at a fractional lag, N a short symmetric average that
makes the difference exact for smooth motion (Numerov's formula and its next order), g a gain and d a slow
offset. Only differences enter, so the unknown state at either end of the record is left free. The
covariance of the noise, S_a N N' + g^2 S_u H H', is banded: the likelihood costs O(n). Where dry friction makes a
jump, at a reversal, N a is off by what `reversal_excess` tells.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from identify.algebra import banded_cholesky, solve_factored
from identify.arrays import Array
from identify.signal.fractional_delay import lagrange_slope_taps, lagrange_taps, split_shift
from identify.signal.smoothing import smooth

_STEPS = 8
_SLOW_TERMS = 2
"""Coefficients of the slow offset: it is a straight line."""


@dataclass(frozen=True, eq=False)
class Pair:
    """Two channels of one motion and the variance of each sample, shape (n,).

    `order` is the number of derivatives from `low` to `high`. A lost sample has been bridged and has a
    variance as large as the motion itself, which is how it is left out. `excess` is taken off the averages N a (see
    `reversal_excess`).
    """

    low: Array
    high: Array
    order: int
    rate: float
    variance_low: Array
    variance_high: Array
    excess: Array


def cut(pair: Pair, start: int) -> Pair:
    """Return the samples of a pair from `start` on."""
    names = ("low", "high", "variance_low", "variance_high", "excess")
    return replace(pair, **{name: getattr(pair, name)[start:] for name in names})


class Stencil(NamedTuple):
    """Weights on consecutive samples: row i reads samples i + first ... i + first + len(taps) - 1."""

    first: int
    taps: Array

    def apply(self, values: Array, rows: range) -> Array:
        """Return the rows' sums, shape (len(rows),)."""
        segment = values[rows.start + self.first : rows.stop + self.first + len(self.taps) - 1]
        return np.correlate(segment, self.taps, "valid")

    def transpose(self, rows_values: Array, rows: range, n: int) -> Array:
        """Return the adjoint: what each of the n samples receives from the rows, shape (n,)."""
        result = np.zeros(n)
        spread = np.convolve(rows_values, self.taps)
        result[rows.start + self.first : rows.start + self.first + len(spread)] = spread
        return result

    def band(self, variance: Array, rows: range) -> Array:
        """Return the covariance of the rows in lower banded form, shape (len(taps), len(rows))."""
        p = len(self.taps)
        segment = variance[rows.start + self.first : rows.stop + self.first + p - 1]
        products = np.zeros((p, p))
        for k in range(p):
            products[k:, k] = self.taps[k:] * self.taps[: p - k]
        windows = np.lib.stride_tricks.sliding_window_view(segment, p)
        return np.ascontiguousarray((windows @ products).T)


AVERAGES = {
    2: Stencil(-2, np.array([-1.0, 24.0, 194.0, 24.0, -1.0]) / 240.0),
    1: Stencil(-2, np.array([11.0, -93.0, 802.0, 802.0, -93.0, 11.0]) / 1440.0),
}
"""N: the mean of the higher channel over the difference (Numerov 1924; Stoermer), by the order of the pair."""

DIFFERENCES = {2: Stencil(-1, np.array([1.0, -2.0, 1.0])), 1: Stencil(0, np.array([-1.0, 1.0]))}
"""The difference of the lower channel, by the order of the pair."""


@dataclass(frozen=True, eq=False)
class Agreement:
    """The most likely relation of a pair near one lag and gain.

    `covariance` belongs to gain, lag (s) and the coefficients of the slow offset.
    `low` and `high` are the smoothed channels that obey the relation exactly, on the lower channel's and the higher
    channel's own clock.
    """

    gain: float
    lag: float
    covariance: Array
    low: Array
    high: Array
    chi_square: float
    degrees: int


def difference(pair: Pair, whole: int, interpolation: Array) -> Stencil:
    """Return H: the difference of the lower channel, read `whole` samples later under (odd) weights, per s^order."""
    first, taps = DIFFERENCES[pair.order]
    return Stencil(
        first + whole - len(interpolation) // 2, np.convolve(interpolation, taps) * pair.rate**pair.order
    )


def agree(pair: Pair, lag: float, gain: float, corner: float | None = None) -> Agreement:
    """Return the maximum-likelihood slow offset of a pair, and its gain and lag, where a `corner` sets them free.

    The corner (cycles per sample) is that of the motion by which gain and lag are read. Gauss-Newton on r' C^-1 r with C
    the covariance at the present lag and gain. The columns for gain and lag are made from the smoothed motion, which makes
    this the exact gradient with the true motion profiled out (errors in variables) and keeps the noise of the channels out
    of the regressors.
    """
    n = len(pair.low)
    time = np.linspace(-1.0, 1.0, n)
    smooth_low = pair.low if corner is None else agree(pair, lag, gain).low
    for _ in range(_STEPS):
        whole, fraction = split_shift(lag * pair.rate)
        interpolated = fraction or corner is not None  # the slope reads as many samples
        h = difference(pair, whole, lagrange_taps(fraction) if interpolated else np.ones(1))
        average = AVERAGES[pair.order]
        rows = _rows(n, h, average)
        if not rows:
            raise np.linalg.LinAlgError("the lag is longer than the record")
        slow = np.column_stack([average.apply(time**k, rows) for k in range(_SLOW_TERMS)])
        columns = slow
        if corner is not None:
            slope = difference(pair, whole, lagrange_slope_taps(fraction) * pair.rate)
            quiet = smooth(smooth_low, corner)
            columns = np.column_stack([h.apply(quiet, rows), gain * slope.apply(quiet, rows), slow])
        averages = average.apply(pair.high, rows) - pair.excess[rows.start : rows.stop]
        residual = averages - gain * h.apply(pair.low, rows)
        factor = banded_cholesky(_covariance(pair, average, h, gain, rows))
        weighted = solve_factored(factor, columns)
        covariance = np.asarray(np.linalg.inv(columns.T @ weighted), dtype=np.float64)
        change = covariance @ (weighted.T @ residual)
        misfit = residual - columns @ change
        score = solve_factored(factor, misfit)
        smooth_low = pair.low + gain * pair.variance_low * h.transpose(score, rows, n)
        smooth_high = pair.high - pair.variance_high * average.transpose(score, rows, n)
        offset = time[:, None] ** np.arange(_SLOW_TERMS) @ change[-_SLOW_TERMS:]
        degrees = len(rows) - columns.shape[1]
        high = smooth_high - offset
        result = Agreement(gain, lag, covariance, smooth_low, high, float(misfit @ score), degrees)
        if corner is None:
            break
        gain, lag = gain + float(change[0]), lag + float(change[1])
        result = replace(result, gain=gain, lag=lag)
        if np.all(np.abs(change[:2]) < 1e-3 * np.sqrt(np.diag(covariance)[:2])):
            break
    return result


def _rows(n: int, h: Stencil, average: Stencil) -> range:
    start = max(0, -h.first, -average.first)
    stop = min(n, n - h.first - len(h.taps) + 1, n - average.first - len(average.taps) + 1)
    return range(start, max(stop, start))


def _covariance(pair: Pair, average: Stencil, h: Stencil, gain: float, rows: range) -> Array:
    low = gain * gain * h.band(pair.variance_low, rows)
    high = average.band(pair.variance_high, rows)
    band = np.zeros((max(len(low), len(high)), len(rows)))
    band[: len(low)] += low
    band[: len(high)] += high
    return band


def reversal_excess(high: Array, velocity: Array, noise: float, order: int) -> Array:
    """Return the excess (n,) of the averages N `high` over the true means, for jumps at the zeros of `velocity`.

    Where dry friction makes the acceleration jump between two samples, the mean over the interval depends on where in it
    the jump fell. One at which the velocity changes sign is taken to have fallen where the velocity is zero, which both
    channels tell within microseconds.

    `high` and `velocity` have shape (n,) and one clock; `noise` is the standard deviation of `high`; `order` is that of the
    pair. A unit jump a share s of the way from sample i to i + 1 has, in rows i and i + 1, the true
    means (1 - s)^2 / 2 and 1 - s^2 / 2 of a second difference, and 1 - s in row i of a first difference.
    """
    n = len(high)
    excess = np.zeros(n)
    steps = np.diff(high)
    jump = np.zeros(n - 1)
    jump[1:-1] = steps[1:-1] - 0.5 * (steps[:-2] + steps[2:])
    crossing = velocity[:-1] * velocity[1:] <= 0.0
    size = np.abs(jump)
    peak = np.zeros(n - 1, dtype=bool)
    peak[1:-1] = (size[1:-1] >= size[:-2]) & (size[1:-1] >= size[2:])
    found = np.flatnonzero(peak & (size > 6.0 * noise))
    first, taps = AVERAGES[order]
    sampled = np.cumsum(taps[::-1])
    for i in found:
        place = next((k for k in (i, i - 1, i + 1) if 0 <= k < n - 1 and crossing[k]), None)
        if place is None or i < 4 or i > n - 6:
            continue
        share = (
            velocity[place] / (velocity[place] - velocity[place + 1])
            if velocity[place] != velocity[place + 1]
            else 0.5
        )
        share = float(np.clip(share + place - i, 0.0, 1.0))
        rows = np.arange(len(taps)) + i + 2 - first - len(taps)
        true = (rows > i).astype(float)
        if order == 2:
            true[rows == i] = 0.5 * (1.0 - share) ** 2
            true[rows == i + 1] = 1.0 - 0.5 * share**2
        else:
            true[rows == i] = 1.0 - share
        excess[rows] += jump[i] * (sampled - true)
    return excess
