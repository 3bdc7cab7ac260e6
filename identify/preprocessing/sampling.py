"""Sampling that is too coarse for a motion: too few readings a cycle to know its velocity and acceleration."""

import numpy as np

from identify.arrays import Array
from identify.signal.oscillation import dominant_frequency

_TOO_FEW = 8.0
"""Readings a cycle below which a refusal is put down to the sampling."""

_ENOUGH = 20.0
_AROUND = 0.1
_MOST_OF_IT = 0.5
"""A motion is an oscillation where so much of its power lies within so much of one frequency."""


def too_coarse(values: Array, rate: float, derivative: int) -> str:
    """Return why a record that oscillates cannot be followed at its `rate` (Hz), in a sentence; "" where it can.

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
