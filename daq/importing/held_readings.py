"""Readings that are held: a program that asks a sensor faster than it answers writes each answer again until the next.

A row that repeats the one before while the mass moves fast is no new reading. The sensor answers by a clock of its own,
which the rows that bring a new reading follow to within the interval between two questions. Where few rows repeat one, as
where a film's frames were doubled to a higher rate, new readings come in nearly every row, and the rows that repeat one
tell the clock: each lies in the last part of a period, as long as the period is longer than the interval.
"""

import numpy as np

from daq.importing.quantisation import quantum
from daq.importing.stamps import Rebuilt
from daq.recording import Array, Mask

LARGE_STEP = 4.0
"""Quanta of a step between two rows, so large that neither repeats by rounding."""

FEWEST_INTERVALS = 24
FEWEST_CHANGES = 40
FEWEST_REPEATS = 12
REPEATED = (0.05, 0.95)
"""Shares of the rows of a fast motion that repeat the one before between which readings are held, if by a clock."""

REGULAR = 0.7
"""New readings come as regularly as those of a clock: at least this share of the concentration that one would show."""

NEAR = 0.1
"""How far, as a share, the sensor's period may be from the mean interval between new readings in fast motion."""

FIRST_CHANGES = 64
AS_HIGH = 0.9
PEAK_WIDTH = 10  # of the periods that are tried: the width of a peak


def held_readings(time: Array, values: Array) -> Rebuilt | None:
    """Return the sensor's clock behind rows with rising stamps `time` (n,), s, and `values` (channels, n); None where
    rows do not repeat readings, or not by a clock.
    """
    steps = np.diff(time)
    if len(time) < 2 * FEWEST_CHANGES or not np.isfinite(time).all() or not np.all(steps > 0.0):
        return None
    new = np.concatenate([[True], np.any(values[:, 1:] != values[:, :-1], axis=0)])
    asked, changes = float(np.median(steps)), time[new]
    size = _steps_in_quanta(values)
    period, rows = _interval(time, size, new)
    share = 1.0 - 1.0 / rows
    if not REPEATED[0] <= share <= REPEATED[1] or len(changes) < FEWEST_CHANGES:
        return None
    shortest = asked / (1.0 - 0.5 * REPEATED[0])
    clock = _clock(changes, period, shortest, asked, FEWEST_CHANGES)
    if clock is None:
        repeats = time[_surely_held(size, new)]
        clock = _clock(repeats, period, shortest, -asked, FEWEST_REPEATS)
    if clock is None:
        return None
    return _on_its_clock(time, *clock, asked, float(np.mean(~new)))


def _steps_in_quanta(values: Array) -> Array:
    """Return the largest step of a channel to each row, shape (n,), in what its readings differ by at least.

    A converter's step, or a picture's pixel, need not be a round number in the unit of the file.
    """
    size = np.zeros(values.shape[1])
    for channel in values:
        step = np.abs(np.diff(channel, prepend=channel[0]))
        rounded = quantum(channel)
        apart = step[step > 0.5 * rounded]
        least = max(rounded, float(np.min(apart, initial=np.inf)) if len(apart) else 0.0)
        size = np.fmax(size, step / max(least, 1e-300))
    return size


def _interval(time: Array, size: Array, new: Mask) -> tuple[float, float]:
    """Return the mean time (s) and the mean number of rows between two new readings that both are large steps; 0 s and
    one row where there are too few.

    Rows are counted, for their stamps may be rounded: 0.03 s is written for most frames of a film at 30 Hz.
    """
    at = np.flatnonzero(new)
    large = size[at] > LARGE_STEP
    both = large[1:] & large[:-1]
    between = np.diff(time[at])[both]
    if len(between) < FEWEST_INTERVALS:
        return 0.0, 1.0
    near = between < 3.0 * np.median(between)
    return float(np.mean(between[near])), float(np.mean(np.diff(at)[both][near]))


def _surely_held(size: Array, new: Mask) -> Mask:
    """Return which rows repeat the one before between two large steps, (n,): one row alone, which no rounding repeats."""
    held = np.zeros(len(new), dtype=bool)
    held[2:-1] = ~new[2:-1] & (size[1:-2] > LARGE_STEP) & (size[3:] > LARGE_STEP)
    return held


def _clock(
    events: Array, period: float, shortest: float, asked: float, fewest: int
) -> tuple[float, float, float] | None:
    """Return period, its error and the middle (s) of new readings' times by rows that bring one, or, where `asked` is
    negative, by rows that repeat one; None where they do not come by a clock.
    """
    if len(events) < fewest:
        return None
    period, regular, centre = _period(events, period, shortest)
    # A clock's readings are seen evenly spread over so much of a period, and repeated over the rest of it.
    spread = asked / period if asked > 0.0 else 1.0 + asked / period
    if spread > 1.0 or regular < max(REGULAR * float(np.sinc(spread)), 4.0 / np.sqrt(len(events))):
        return None
    middle = centre if asked > 0.0 else centre + 0.5 * period
    span = max((events[-1] - events[0]) / period, 1.0)
    return period, spread * period / np.sqrt(len(events)) / span, middle


def _period(changes: Array, period: float, shortest: float) -> tuple[float, float, float]:
    """Return the period (s) near a first guess at which changes (m,) bunch most, how much (0 to 1), and at what time.

    First of a few changes close together, whose phase a wrong period does not yet turn, then of twice as many each time.
    Periods below the `shortest` are not tried: at the interval of the rows themselves all rows bunch.
    """
    reach, count = NEAR, min(FIRST_CHANGES, len(changes))
    first = int(np.argmin(changes[count - 1 :] - changes[: len(changes) - count + 1]))  # not over a rest
    while True:
        first = min(first, len(changes) - count)
        part = changes[first : first + count]
        span = max(float(part[-1] - part[0]) / period, 1.0)
        tried = period * (1.0 + np.arange(-reach, reach + 1e-12, 0.1 / span))
        bunched = np.exp(2j * np.pi * part / tried[:, None]).mean(axis=1)
        bunched[tried < shortest] = 0.0
        best = _nearest_of_the_best(np.abs(bunched), len(tried) // 2)
        period = float(tried[best])
        if count == len(changes):
            centre = float(np.angle(bunched[best])) / (2.0 * np.pi) * period
            return period, float(np.abs(bunched[best])), centre
        reach, count = 1.0 / span, min(2 * count, len(changes))


def _nearest_of_the_best(bunched: Array, middle: int) -> int:
    """Return the peak next to the middle of those as high: questions by an even clock make an image of each period."""
    peaks = np.flatnonzero(bunched >= AS_HIGH * float(bunched.max()))
    near = int(peaks[np.argmin(np.abs(peaks - middle))])
    group = peaks[np.abs(peaks - near) <= PEAK_WIDTH]
    return int(group[np.argmax(bunched[group])])


def _on_its_clock(
    time: Array, period: float, std: float, centre: float, asked: float, share: float
) -> Rebuilt:
    """Return the last row of each period around the times at which new readings are seen; periods without a row are lost."""
    first = int(np.ceil((time[0] - centre) / period - 0.5))
    last = int(np.floor((time[-1] - centre) / period + 0.5))
    number = np.arange(first, last + 1)
    begin = centre + (number - 0.5) * period
    rows = np.searchsorted(time, begin + period) - 1
    there = (rows >= 0) & (time[np.maximum(rows, 0)] >= begin)
    number, rows = number[there], rows[there]
    start = centre + number[0] * period - 0.5 * asked
    note = (
        f"{100.0 * share:.0f} % of the rows repeat the one before while the mass moves: the sensor was read faster "
        "than it answers; its own readings, {}, were taken (--rate keeps all rows)"
    )
    return Rebuilt(
        period, std, float(start), rows.astype(np.int64), (number - number[0]).astype(np.int64), note
    )
