"""Readings that are held: a program that asks a sensor faster than it answers writes each answer again until the next.

A row that repeats the one before while the mass moves fast is no new reading. The sensor answers by a clock of its own,
which the rows that bring a new reading follow to within the interval between two questions.
"""

import numpy as np

from daq.importing.quantisation import quantum
from daq.importing.stamps import Rebuilt
from daq.recording import Array, Mask

LARGE_STEP = 4.0
"""Quanta of a step between two rows, so large that neither repeats by rounding."""

FEWEST_INTERVALS = 24
FEWEST_CHANGES = 40
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
    at = np.flatnonzero(new)
    large = _is_large(values)[at]
    both = large[1:] & large[:-1]
    between = np.diff(changes)[both]
    if len(between) < FEWEST_INTERVALS or len(changes) < FEWEST_CHANGES:
        return None
    near = between < 3.0 * np.median(between)
    # Rows, as stamps may be rounded: 0.03 s is written for most frames of a film.
    rows = float(np.mean(np.diff(at)[both][near]))
    if not REPEATED[0] <= 1.0 - 1.0 / rows <= REPEATED[1]:
        return None
    shortest = asked / (1.0 - 0.5 * REPEATED[0])
    period, regular, centre = _period(changes, float(np.mean(between[near])), shortest)
    spread = asked / period  # by so much of a period the readings of a clock are late, evenly
    if spread > 1.0 or regular < max(REGULAR * float(np.sinc(spread)), 4.0 / np.sqrt(len(changes))):
        return None
    error = spread * period**2 / np.sqrt(len(changes)) / max(changes[-1] - changes[0], period)
    return _on_its_clock(time, period, error, centre, asked, float(np.mean(~new)))


def _is_large(values: Array) -> Mask:
    """Return which rows, (n,), a channel reaches by a large step, in what its readings differ by at least.

    A converter's step, or a picture's pixel, need not be a round number in the unit of the file.
    """
    large = np.zeros(values.shape[1], dtype=bool)
    for channel in values:
        step, rounded = np.abs(np.diff(channel, prepend=channel[0])), quantum(channel)
        least = np.min(step[step > 0.5 * rounded], initial=np.inf)
        large |= step > LARGE_STEP * max(rounded, float(least) if np.isfinite(least) else 1e-300)
    return large


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
