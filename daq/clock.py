"""How fast the samples really come, and how evenly: lines through the times at which they were taken or arrived."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

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

BURSTS = 0.8
"""Bursts a frame below which a line is taken to hold frames back; in one burst less than a quarter of a frame passes."""

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
    the sample from which on it may have been.
    """

    share: float
    step: float
    after: int
    index: int


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
    line goes through the promptest arrival of each part of the record, and its error is their scatter. Bursts that come
    by a clock of their own may drift against the frames, by a frame at most: that is added.
    """
    envelopes, held_s = _envelopes(indices, times)
    fits = [_line(*points) for points in envelopes]
    best = min((fit for fit in fits if fit is not None), key=lambda fit: fit.std, default=None)
    if best is None:
        return None
    drift = best.rate * held_s / best.span / 12**0.5
    return replace(best, std=float(np.hypot(best.std, drift)))


def lasting_step(indices: Sequence[int], times: Sequence[float]) -> Unevenness | None:
    """Return the largest step in the arrivals (s) that stays to the end, so that no late frame explains it; or None.

    It must exceed six standard errors of what is left beside it, and part the promptest arrivals before it from all
    those after it by half its size. Where samples come in bursts, a frame that just missed one makes no step.
    """
    envelopes, held_s = _envelopes(indices, times)
    least = max(LEAST_STEP_S, 1.5 * held_s)
    found = [step for points in envelopes if (step := _step(*points, least)) is not None]
    return max(found, key=lambda step: step.share, default=None)


def unevenness(indices: Sequence[int], times_us: Sequence[int]) -> Unevenness | None:
    """Measure how far the board's times (us) of the samples `indices`, in order, differ from even ones; None with one.

    Their own typical spacing is taken for even, whatever the rate; what their rounding explains is left out.
    """
    if len(indices) < 2:
        return None
    index = np.asarray(indices, dtype=np.int64)
    whole = np.array([us - times_us[0] for us in times_us], dtype=np.float64)
    time = 1e-6 * whole
    far = max(len(index) // 8, 1)  # far enough apart for rounding, near enough for one step to count seldom
    period = float(np.median((time[far:] - time[:-far]) / (index[far:] - index[:-far])))
    away = time - period * (index - index[0])
    jumps = np.abs(np.diff(away))
    halves = np.minimum((index - index[0]) * abs(period) / (0.5 * WINDOW_S), 2.0**60).astype(np.int64)
    starts = np.flatnonzero(np.diff(halves, prepend=-1))
    high, low = np.maximum.reduceat(away, starts), np.minimum.reduceat(away, starts)
    if len(starts) > 1:
        high, low = np.maximum(high[1:], high[:-1]), np.minimum(low[1:], low[:-1])
    worst = int(np.argmax(high - low))
    first, stop = int(starts[worst]), int([*starts, len(index), len(index)][worst + 2])
    here = away[first:stop]
    apart = float(np.ptp(here)) * (1.0 if np.argmax(here) >= np.argmin(here) else -1.0)
    at = first + int(np.argmax(jumps[first : stop - 1]))
    share = max(abs(apart) - 2.0 * _rounding(whole, jumps), 0.0) / WINDOW_S
    return Unevenness(share, apart, int(index[at]), int(index[at + 1]))


def _rounding(times_us: Array, jumps: Array) -> float:
    """Find the step (s) to which stamps (us) are rounded: a whole millisecond, or what divides all of them."""
    few = 1 + len(jumps) // 50  # that a step or late stamps make
    usual = np.sort(jumps)[:-few]
    if not len(usual) or np.ptp(times_us) > 2**53:
        return 1e-6
    grain = 1e-6 * int(np.gcd.reduce(np.abs(np.diff(times_us)).astype(np.int64)))
    if abs(grain / COARSEST_STAMP_S - round(grain / COARSEST_STAMP_S)) < 1e-6:
        return COARSEST_STAMP_S
    return max(1e-6, min(grain, COARSEST_STAMP_S, 4.0 * float(np.sqrt(np.mean(usual**2)))))


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


def _envelopes(indices: Sequence[int], times: Sequence[float]) -> tuple[list[tuple[Array, Array]], float]:
    """Return the promptest arrivals, (index, time) each, for each number of parts that the bursts suffice for.

    Of what follows within a quarter of the time from frame to frame, a burst, the end counts: the sample after its last,
    and when it came (s). The time of a frame (s) is returned where frames are held, else 0.
    """
    index, time = np.asarray(indices, dtype=np.float64), np.asarray(times, dtype=np.float64)
    order = np.argsort(time, kind="stable")
    index, time = np.maximum.accumulate(index[order]), time[order]
    frame = float(np.ptp(time)) / len(time) if len(time) else 0.0
    last = np.diff(time, append=np.inf) > 0.25 * frame
    held_s = frame if last.sum() < BURSTS * len(time) else 0.0
    index, time = index[last], time[last]
    found = []
    for blocks in (n for n in BLOCKS if n <= len(index) and np.ptp(index) > 0):
        edges = np.linspace(index.min(), index.max(), blocks + 1)[1:-1]
        part = np.searchsorted(edges, index, side="left")
        kept = np.arange(len(index))
        for _ in range(3):  # the line decides which is promptest, and they decide the line
            line = np.polynomial.Polynomial.fit(index[kept], time[kept], 1)
            order = np.lexsort((time - line(index), part))
            kept = order[np.flatnonzero(np.diff(part[order], prepend=-1))]
        if len(kept) > blocks // 2:
            found.append((index[kept], time[kept]))
    return found, held_s


def _step(index: Array, time: Array, least: float) -> Unevenness | None:
    """Fit a line with one step at each place between the points of an envelope; return the best if it is certain.

    What the line makes up for afterwards, as one that catches up after a stall, is no step that lasts.
    """
    best: tuple[float, Unevenness] | None = None
    for k in range(LEAST_SIDE, len(index) - LEAST_SIDE + 1):
        after = np.arange(len(index)) >= k
        columns = np.stack([np.ones_like(index), index - index.mean(), after], axis=1)
        found, *_ = np.linalg.lstsq(columns, time, rcond=None)
        left = time - columns @ found
        variance = float(left @ left) / (len(index) - 3)
        error = 2.0 * np.sqrt(variance * np.linalg.inv(columns.T @ columns)[2, 2])
        step = float(found[2])
        apart = np.sign(step) * left + abs(step) * after
        lasts = apart[k:].min() - apart[:k].max() > 0.5 * abs(step)
        before = np.polynomial.Polynomial.fit(index[:k], time[:k], 1)
        lasts &= (time[k:] - before(index[k:])).min() * np.sign(step) > 0.5 * abs(step)
        if lasts and abs(step) > max(STEP_SIGMAS * error, least) and (best is None or variance < best[0]):
            best = variance, Unevenness(abs(step) / WINDOW_S, step, int(index[k - 1]), int(index[k]))
    return None if best is None else best[1]
