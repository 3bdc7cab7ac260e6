"""How fast the samples really come, and how evenly: lines through the times at which they were taken or arrived."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from daq.recording import Array

LEAST_STAMPS = 8
BLOCKS = (8, 16, 32)
"""Into how many parts a record is cut in search of its promptest arrivals: as many as the line's bursts leave sharpest."""

WINDOW_S = 1.0
"""The shortest stretch of a decay that its stiffness rests on: what times are off within it is an error of the rate."""

COARSEST_STAMP_S = 1e-3
"""The coarsest stamps that boards print: whole milliseconds. What rounding to them may hide is not uneven sampling."""

LEAST_SIDE = 4
"""Points of the envelope that a lasting step must have on both sides."""

STEP_SIGMAS = 6.0
LEAST_STEP_S = 2e-3
"""What an operating system's own haste and delay may shift the promptest arrivals by."""


@dataclass(frozen=True)
class ClockFit:
    """The measured rate in Hz, its standard error, and the span in s over which it was measured."""

    rate: float
    std: float
    span: float


@dataclass(frozen=True)
class Unevenness:
    """How far the times of samples part from even ones: within a second, as a share of it, and where it is worst.

    `step` (s; +: time passed that the index did not count) is how far they part before the sample `index`, and `after`
    the sample from which on it may have been. `rounding` (s) is what the stamps themselves were rounded to.
    """

    share: float
    step: float
    after: int
    index: int
    rounding: float = 0.0


def fit_clock(indices: Sequence[int], times: Sequence[float]) -> ClockFit | None:
    """Return samples per second by least squares over (index, time in s); None with fewer than 8 points.

    The standard error is twice that of independent residuals, because neighbours err together.
    """
    if len(indices) < LEAST_STAMPS:
        return None
    return _line(np.asarray(indices, dtype=np.float64), np.asarray(times, dtype=np.float64))


def fit_arrivals(indices: Sequence[int], times: Sequence[float]) -> ClockFit | None:
    """Return samples per second by when they arrived (s); None with fewer than 8 arrivals.

    Nothing arrives before it was taken, and a line that holds data back delivers the last of a burst promptly. So the
    line goes through the promptest arrival of each part of the record, and its error is their scatter.
    """
    fits = [_line(*points) for points in _envelopes(indices, times)]
    return min((fit for fit in fits if fit is not None), key=lambda fit: fit.std, default=None)


def lasting_step(indices: Sequence[int], times: Sequence[float]) -> Unevenness | None:
    """Return the largest step in the arrivals (s) that stays to the end, so that no late frame explains it; or None.

    It must exceed six standard errors of what is left beside it, and part the promptest arrivals before it from all
    those after it by half its size. Where most arrivals bring several frames, it must exceed a frame, which may have just
    missed the burst before.
    """
    least, arrivals = LEAST_STEP_S, len(set(times))
    if 0 < 2 * arrivals < len(times):
        least = max(least, (max(times) - min(times)) / len(times))
    found = [step for points in _envelopes(indices, times) if (step := _step(*points, least)) is not None]
    return max(found, key=lambda step: step.share, default=None)


def unevenness(indices: Sequence[int], times_us: Sequence[int]) -> Unevenness | None:
    """Return how far the board's times (us) of the samples `indices`, in order, part from even ones; None with one.

    Their own typical spacing is taken for even, whatever the rate; what their rounding explains is left out.
    """
    if len(indices) < 2:
        return None
    index = np.asarray(indices, dtype=np.int64)
    whole = np.array([us - times_us[0] for us in times_us], dtype=np.float64)
    time, far = (
        1e-6 * whole,
        max(len(index) // 8, 1),
    )  # far enough for rounding, too near for one step to count
    period = float(np.median((time[far:] - time[:-far]) / (index[far:] - index[:-far])))
    away = time - period * (index - index[0])
    jumps = np.diff(away)
    usual = np.sort(np.abs(jumps))[
        : -1 - len(jumps) // 50
    ]  # without the few that a step or a late stamp makes
    grain = (
        1e-6 * float(np.gcd.reduce(np.abs(np.diff(whole)).astype(np.int64))) if np.ptp(whole) < 2**53 else 0.0
    )
    rounding = max(
        1e-6, min(grain, COARSEST_STAMP_S, 4.0 * float(np.sqrt(np.mean(usual**2))) if len(usual) else 0.0)
    )
    bins = np.minimum((index - index[0]) * abs(period) / (0.5 * WINDOW_S), 2.0**60).astype(np.int64)
    starts = np.flatnonzero(np.diff(bins, prepend=bins[0] - 1))
    high, low = np.maximum.reduceat(away, starts), np.minimum.reduceat(away, starts)
    if len(starts) > 1:
        high, low = np.maximum(high[1:], high[:-1]), np.minimum(low[1:], low[:-1])
    worst = int(np.argmax(high - low))
    first = int(starts[worst])
    stop = int(starts[worst + 2]) if worst + 2 < len(starts) else len(index)
    here = away[first:stop]
    at = first + int(np.argmax(np.abs(jumps[first : stop - 1])))  # two parts hold two stamps at least
    apart = float(np.ptp(here)) * (1.0 if np.argmax(here) >= np.argmin(here) else -1.0)
    share = max(abs(apart) - 2.0 * rounding, 0.0) / WINDOW_S
    return Unevenness(share, apart, int(index[at]), int(index[at + 1]), rounding)


def _line(index: Array, time: Array) -> ClockFit | None:
    span = float(np.ptp(time))
    index = index - index.mean()
    time = time - time.mean()
    square = float(index @ index)
    period = float(index @ time) / square if square else 0.0
    if not np.isfinite(period) or period <= 0:
        return None
    residual = time - period * index
    std = 2 * float(np.sqrt(residual @ residual / (len(index) - 2) / square))
    return ClockFit(1 / period, std / period**2, span)


def _envelopes(indices: Sequence[int], times: Sequence[float]) -> list[tuple[Array, Array]]:
    """Return the promptest arrivals, (index, time) each, for each number of parts that the arrivals suffice for."""
    index, time = np.asarray(indices, dtype=np.float64), np.asarray(times, dtype=np.float64)
    most = len(np.unique(time))  # what came at once is one arrival
    if most < LEAST_STAMPS:
        return []
    found = []
    for blocks in BLOCKS:
        if blocks > most:
            break
        edges = np.linspace(index.min(), index.max(), blocks + 1)[1:-1]
        part = np.searchsorted(edges, index, side="left")
        kept = np.arange(len(index))
        for _ in range(3):  # the line decides which is promptest, and they decide the line
            line = np.polynomial.Polynomial.fit(index[kept], time[kept], 1)
            order = np.lexsort((time - line(index), part))
            kept = order[np.flatnonzero(np.diff(part[order], prepend=-1))]
        found.append((index[kept], time[kept]))
    return found


def _step(index: Array, time: Array, least: float) -> Unevenness | None:
    """Fit a line with one step at each place between the points of an envelope; return the best if it is certain."""
    best: tuple[float, Unevenness] | None = None
    for k in range(LEAST_SIDE, len(index) - LEAST_SIDE + 1):
        columns = np.stack([np.ones_like(index), index - index.mean(), np.arange(len(index)) >= k], axis=1)
        found, *_ = np.linalg.lstsq(columns, time, rcond=None)
        left = time - columns @ found
        variance = float(left @ left) / (len(index) - 3)
        error = 2.0 * np.sqrt(variance * np.linalg.inv(columns.T @ columns)[2, 2])
        step = float(found[2])
        apart = np.sign(step) * left + abs(step) * columns[:, 2]
        lasts = apart[k:].min() - apart[:k].max() > 0.5 * abs(step)
        if lasts and abs(step) > max(STEP_SIGMAS * error, least) and (best is None or variance < best[0]):
            best = variance, Unevenness(abs(step) / WINDOW_S, step, int(index[k - 1]), int(index[k]))
    return None if best is None else best[1]
