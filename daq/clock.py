"""How fast the samples really come: a straight line through the times at which they were taken or arrived."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

LEAST_STAMPS = 8
STEP_SAMPLES = 0.5
MOST_STEPS = 200


@dataclass(frozen=True)
class ClockFit:
    """The measured rate in Hz, its standard error, and the span in s over which it was measured."""

    rate: float
    std: float
    span: float


def fit_clock(indices: Sequence[int], times: Sequence[float]) -> ClockFit | None:
    """Return samples per second by least squares over (index, time in s); None with fewer than 8 points.

    The standard error is twice that of independent residuals, because arrivals come in bursts.
    """
    if len(indices) < LEAST_STAMPS:
        return None
    index = np.asarray(indices, dtype=np.float64)
    time = np.asarray(times, dtype=np.float64)
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


@dataclass(frozen=True)
class ClockStep:
    """The sample before which the board's clock and its sample index part, and by how many samples (+: time passed).

    `after` is the sample from which on it may have been.
    """

    after: int
    index: int
    samples: float


def clock_steps(indices: Sequence[int], times_us: Sequence[int], rate: float) -> tuple[ClockStep, ...]:
    """Return where the time of a sample is more than half a sample off its index, beside a constant rate.

    `times_us` is the board's clock (us) at the samples `indices`. The rate of that clock is found from the stamps
    themselves, as it may be off by what `fit_clock` finds; `rate` (Hz) is used with fewer than 8 of them. The
    stamps are whole microseconds, so another two of them are allowed.
    """
    if len(indices) < 2:
        return ()
    order = np.argsort(np.asarray(indices, dtype=np.int64))
    index = np.asarray(indices, dtype=np.int64)[order].astype(np.float64)
    time = np.array([times_us[i] - times_us[int(order[0])] for i in order.tolist()], dtype=np.float64) * 1e-6
    spacing = np.diff(time) / np.diff(index)
    period = float(np.median(spacing)) if len(indices) >= LEAST_STAMPS else 1 / rate
    if not period > 0:
        return (
            ClockStep(
                int(index[0]), int(index[1]), float((time[1] - time[0]) * rate - (index[1] - index[0]))
            ),
        )
    allowed = STEP_SAMPLES + 2e-6 / period
    steps = np.diff(time) / period - np.diff(index)
    found = np.flatnonzero(np.abs(steps) > allowed)
    if len(found):
        return tuple(
            ClockStep(int(index[i]), int(index[i + 1]), float(steps[i])) for i in found[:MOST_STEPS].tolist()
        )
    if len(indices) < LEAST_STAMPS:
        return ()
    away = time - np.polynomial.Polynomial.fit(index, time, 1)(index)
    worst = int(np.argmax(np.abs(away)))
    drift = float(away[worst]) / period
    return (ClockStep(int(index[worst]), int(index[worst]), drift),) if abs(drift) > allowed else ()
