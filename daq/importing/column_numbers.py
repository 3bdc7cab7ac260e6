"""What the numbers of a column show: whether they move or oscillate, and to which step they were rounded."""

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


def is_offset(values: Array) -> bool:
    """Check whether the numbers swing about something else than 0: their median is larger than their standard deviation."""
    return is_measurable(values) and abs(float(np.nanmedian(values))) > amplitude(values)


def counts_rows(values: Array) -> bool:
    """Check whether whole numbers count the rows, from any number on."""
    return len(values) > 2 and bool(values[0] == np.rint(values[0])) and bool(np.all(np.diff(values) == 1.0))


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


def quantum(values: Array) -> float:
    """Return the step of which the numbers are multiples, as they were written; the steps tried are 1, 2, 2.5
    and 5 times a power of ten. One number in a hundred may stray (zeros written as 1e-13); 0 when there are too few.

    Only numbers of the largest decade are looked at: where a file keeps significant digits, these are rounded most.
    """
    finite = np.abs(values[np.isfinite(values)][:20_000])
    top = float(np.max(finite, initial=0.0))
    if len(finite) < 3 or not 1e-200 < top < 1e200:
        return 0.0
    floor = 64.0 * float(np.spacing(top))
    large = finite[finite >= 10.0 ** np.floor(np.log10(top))]
    finite = large if len(large) >= 50 else finite
    exponent = int(np.ceil(np.log10(top)))
    while 10.0**exponent > floor:
        for mantissa in (1.0, 0.5, 0.25, 0.2):
            step = mantissa * 10.0**exponent
            multiples = finite / step
            far = np.abs(multiples - np.rint(multiples)) > 1e-3 + floor / step
            if np.count_nonzero(far) <= len(finite) // 100:
                return step
        exponent -= 1
    return floor
