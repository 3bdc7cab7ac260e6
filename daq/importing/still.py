"""Columns that stand still, or oscillate: a sensor that was connected, beside one that moved."""

import numpy as np

from daq.recording import Array

LARGEST = 1e100


def is_measurable(values: Array) -> bool:
    """Check whether there are numbers, and all of a size whose squares can be summed."""
    finite = values[np.isfinite(values)]
    return len(finite) > 0 and bool(np.max(np.abs(finite)) < LARGEST)


def amplitude(values: Array) -> float:
    """Return the standard deviation of the numbers that are there, 0 when there are fewer than two."""
    finite = values[np.isfinite(values)]
    return float(np.std(finite)) if len(finite) > 1 and is_measurable(finite) else 0.0


def oscillation(values: Array) -> float:
    """Return the share of a column's power, its slope taken out, within 20 % of its strongest frequency; 0 to 1."""
    finite = values[np.isfinite(values)]
    if len(finite) < 16 or not is_measurable(finite) or np.ptp(finite) == 0.0:
        return 0.0
    place = np.linspace(-1.0, 1.0, len(finite))
    scaled = (finite - finite.mean()) / np.ptp(finite)
    power = (
        np.abs(
            np.fft.rfft((scaled - np.polyval(np.polyfit(place, scaled, 1), place)) * np.hanning(len(finite)))
        )
        ** 2
    )
    total = float(power.sum())
    if len(power) < 8 or total == 0.0:
        return 0.0
    peak = int(np.argmax(power[3:])) + 3
    reach = max(2, round(0.2 * peak))
    return float(power[max(peak - reach, 0) : peak + reach + 1].sum()) / total
