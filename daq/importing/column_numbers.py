"""What the numbers of columns show: whether they move or oscillate, their rounding, which was computed from another."""

import numpy as np

from daq.recording import Array, runs
from daq.smooth_course import spectrum

LARGEST = 1e100
MIN_ROWS = 40
MAX_ROWS = 40_000
PREDICTED = 0.6
"""Share of a channel's noise that is left at most where a difference of its source predicts the noise."""
VISIBLE = 3.0
"""So many times what a smooth oscillation leaves in them must be in the sixth differences, to be noise."""
STRAY = 3.0
"""So many times the usual rest a row may be off and still say how large a difference is."""
FINEST = 1e-5
"""Share of its range to which a logger that writes six digits rounds a number."""
FIRST = (
    (-1.0, 1.0, 0.0),
    (0.0, -1.0, 1.0),
    (-0.5, 0.0, 0.5),
    (-1 / 6, -1 / 6, 0.0, 1 / 6, 1 / 6),
    (-1 / 36, -3 / 36, -9 / 36, 0.0, 9 / 36, 3 / 36, 1 / 36),  # Logger Pro
    *(tuple(3.0 * k / (m * (m + 1) * (2 * m + 1)) for k in range(-m, m + 1)) for m in (2, 3, 4, 5, 6)),
)


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


def counts_rows(values: Array, *, any_step: bool = False) -> bool:
    """Check whether whole numbers count the rows from any number on, every one, or in `any_step` that is whole."""
    if len(values) < 3 or not (values[:2] == np.rint(values[:2])).all():
        return False
    steps = np.diff(values)
    return bool(np.all(steps == (max(steps[0], 1.0) if any_step else 1.0)))


def oscillation(values: Array) -> float:
    """Return the share of a column's power, its slope taken out, within 20 % of its strongest frequency; 0 to 1."""
    finite = values[np.isfinite(values)]
    if len(finite) < 16 or not is_measurable(finite) or np.ptp(finite) == 0.0:
        return 0.0
    power = spectrum(finite / np.ptp(finite))
    total = float(power.sum())
    if total == 0.0:
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


def is_difference(source: Array, channel: Array, order: int) -> bool:
    """Check whether `channel` was computed as the derivative of that `order` of `source`, in whatever units.

    A logger's derivative repeats the noise of its source: one fixed finite difference of the source predicts it. A second
    sensor has a noise of its own, which nothing in the source predicts. The differences that loggers use are tried.
    Both have shape (n,), NaN where there is no number. No more than rounding may be left beside the difference: two sensors
    that share a high mode leave more. False also where no noise is seen, or there are too few samples.
    """
    known = runs(np.isfinite(source) & np.isfinite(channel))
    start, stop = max(known, key=lambda run: run[1] - run[0], default=(0, 0))
    x, y = (values[start : min(stop, start + MAX_ROWS)] for values in (source, channel))
    if len(x) < MIN_ROWS or not (0.0 < np.ptp(x) < 1e100 and 0.0 < np.ptp(y) < 1e100):
        return False
    steps = max(quantum(x) / np.ptp(x), FINEST), max(quantum(y) / np.ptp(y), FINEST)
    x, y = (x - x.mean()) / np.ptp(x), y / np.ptp(y)
    if _noise(y) < VISIBLE * _of_motion(y):
        return False
    kernels = FIRST if order == 1 else ((1.0, -2.0, 1.0), *(np.convolve(k, k) for k in FIRST))
    for kernel in map(np.array, kernels):
        reach = len(kernel) // 2
        made, target = np.convolve(x, kernel[::-1], "valid"), y[reach : len(y) - reach]
        gain, rest = 0.0, np.zeros(len(made))
        for _ in range(2):  # without the rows where the logger's own steps of time differ
            usual = np.abs(rest) <= STRAY * np.median(np.abs(rest))
            gain = float(made[usual] @ target[usual]) / max(float(made[usual] @ made[usual]), 1e-300)
            rest = target - gain * made
        rounding = np.hypot(steps[1], gain * steps[0] * np.linalg.norm(kernel)) / np.sqrt(12.0)
        if _noise(rest) < PREDICTED * _noise(target) and np.median(np.abs(rest)) < rounding:
            return True
    return False


def _noise(values: Array) -> float:
    """Return the standard deviation of the white noise that has the same sixth differences, but for a few strays."""
    return float(np.median(np.abs(np.diff(values, 6))) / 0.6745 / np.sqrt(924.0))


def _of_motion(values: Array) -> float:
    """Return what an oscillation at the strongest frequency leaves in the sixth differences, as such a noise."""
    power = np.abs(np.fft.rfft((values - values.mean()) * np.hanning(len(values)))) ** 2
    frequency = min(float(np.argmax(power[1:]) + 1) / len(values), 0.5)
    return float(np.std(values) * (2.0 * np.sin(np.pi * frequency)) ** 6 / np.sqrt(924.0))
