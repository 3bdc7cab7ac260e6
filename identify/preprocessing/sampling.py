"""Sampling that is too coarse for a motion: too few readings a cycle to know its velocity and acceleration."""

import numpy as np

from identify.arrays import Array, Mask
from identify.signal.oscillation import dominant_frequency
from identify.signal.running import runs_of

_TOO_FEW = 8.0
"""Readings a cycle below which a refusal is put down to the sampling."""

_ENOUGH = 20.0
_AROUND = 0.1
_MOST_OF_IT = 0.5
"""A motion is an oscillation where so much of its power lies within so much of one frequency."""


def too_coarse(values: Array, rate: float, derivative: int) -> str:
    """Say why an oscillation cannot be followed at its `rate` (Hz); "" where it can.

    `values` (n,) are readings of the displacement or of one of its derivatives.
    """
    frequency = dominant_frequency(values, rate, derivative)
    if frequency <= 0.0 or rate >= _TOO_FEW * frequency or not _oscillates(values, rate, frequency):
        return ""
    return (
        f"The record has {rate:.3g} readings a second of a motion at about {frequency:.2g} Hz, {rate / frequency:.2g} a "
        f"cycle: too few to follow it. Record at {_ENOUGH * frequency:.0f} Hz or faster."
    )


def _oscillates(values: Array, rate: float, frequency: float) -> bool:
    power = np.abs(np.fft.rfft((values - np.mean(values)) * np.hanning(len(values)))) ** 2
    bins = np.fft.rfftfreq(len(values), 1.0 / rate)
    moving = bins > 0.3 * frequency
    near = np.abs(bins - frequency) < _AROUND * frequency
    return bool(power[near].sum() > _MOST_OF_IT * max(float(power[moving].sum()), 1e-300))


LONG_GAP = 0.5
"""Cycles of lost readings from which on they end an analysis: the motion across them is not known."""

LONG_LOSS = 0.33
"""Share of a cycle from which on lost samples are a hole in the running amplitude; shorter ones are bridged."""


def block_means(values: Array | Mask, step: int) -> Array:
    """Return the means of whole blocks of `step` samples, of a mask the shares."""
    count = len(values) // step
    return np.asarray(values[: count * step].reshape(count, step).mean(axis=1))


def over_gaps(amplitude: Array, lost: Mask, step: int, lap: int) -> Array:
    """Return a running amplitude with a straight line over long losses: it sees none of the motion in there.

    Of blocks of `step` samples; a loss is long from a third of a cycle (`lap` blocks), and is seen one cycle away.
    """
    blocks = block_means(lost, step)[: len(amplitude)] > 0.5
    unseen = np.zeros(len(amplitude), dtype=bool)
    for begin, end in runs_of(blocks):
        if end - begin > LONG_LOSS * lap:
            unseen[max(begin - lap, 0) : end + lap] = True
    if not unseen.any() or unseen.all():
        return amplitude
    place = np.arange(len(amplitude))
    return np.where(unseen, np.interp(place, place[~unseen], amplitude[~unseen]), amplitude)


def first_gap(lost: Mask, start: int, period: float) -> int:
    """Find the first gap of readings so long that the motion across it is not known; the end where there is none."""
    gaps = (
        begin for begin, end in runs_of(lost) if begin > start + period and end - begin >= LONG_GAP * period
    )
    return next(gaps, len(lost))
