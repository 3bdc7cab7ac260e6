"""Tell a channel that the logger computed from another one from a sensor of its own.

A logger's derivative repeats the noise of its source, filtered: one fixed finite difference of the source
gives it to within the rounding of the numbers in the file. A second sensor has a noise of its own, which
nothing in the source predicts. So three things are asked together: the best finite difference leaves
no more than rounding allows; it explains the channel's noise and not only its motion; it is a difference
(no answer to a constant) with the slope of a derivative.
"""

from dataclasses import dataclass

import numpy as np

from daq.recording import Array, Mask

REACH = 6
MIN_ROWS = 40
MAX_ROWS = 40_000
NOISE_ORDER = 6
ROUNDING_FACTOR = 3.0
NOISE_FACTOR = 0.25
SLOPE_TOLERANCE = 0.1


@dataclass(frozen=True)
class Derivation:
    """How well a finite difference of the source gives the channel: rms left over, and rms of the channel."""

    residual: float
    rms: float


def quantum(values: Array) -> float:
    """Return the step of which the numbers are multiples, as they were written; the steps tried are 1, 2, 2.5
    and 5 times a power of ten. One number in a hundred may stray (zeros written as 1e-13); 0 when there are too few.
    """
    finite = values[np.isfinite(values)][:20_000]
    top = float(np.max(np.abs(finite), initial=0.0))
    if len(finite) < 3 or not 1e-200 < top < 1e200:
        return 0.0
    floor = 64.0 * float(np.spacing(top))
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


def find_derivation(
    source: Array, channel: Array, rate: float, order: int, stamps: Array | None = None
) -> Derivation | None:
    """Return how `channel` was computed as the derivative of that `order` of `source`, or None if it was not.

    All have shape (n,) and SI units; `stamps` (s) serve where they stray from the even clock of `rate` Hz, since
    a logger divides by its own time steps. None also when there is too little to tell.
    """
    stretch = _longest(np.isfinite(source) & np.isfinite(channel))
    if stretch.stop - stretch.start < MIN_ROWS:
        return None
    x, y = source[stretch], channel[stretch]
    if stamps is None:
        return _difference(x, y, rate, order)
    steps = np.diff(stamps[stretch]) * rate
    first, last = steps[:1], steps[-1:]
    backward, forward = np.concatenate((first, steps)), np.concatenate((steps, last))
    for local in (0.5 * (backward + forward), backward, forward):
        found = _difference(x, y * local**order, rate, order)
        if found:
            return found
    return None


def _difference(x: Array, y: Array, rate: float, order: int) -> Derivation | None:
    if not (np.ptp(x) > 0.0 and np.ptp(y) > 0.0 and max(np.max(np.abs(x)), np.max(np.abs(y))) < 1e100):
        return None
    shifts = np.arange(-REACH, REACH + 1)
    centre = x - x.mean()
    matrix = np.column_stack([np.ones(len(x) - 2 * REACH), *(centre[REACH + k : len(x) - REACH + k] for k in shifts)])
    target = y[REACH : len(y) - REACH]
    step_x, step_y = quantum(x), quantum(y)
    kernel = np.linalg.lstsq(matrix, target, rcond=None)[0]
    residual = target - matrix @ kernel
    taps = kernel[1:] * rate**-order
    rounding = np.sqrt((step_y**2 + step_x**2 * float(kernel[1:] @ kernel[1:])) / 12.0)
    left = float(np.sqrt(np.mean(residual**2)))
    noise, noise_left = _noise(target), _noise(residual)
    moments = [float(taps @ shifts**k) for k in range(order + 1)]
    slope = moments[order] / (2.0 if order == 2 else 1.0)
    is_difference = all(abs(m) < SLOPE_TOLERANCE for m in moments[:1]) and abs(slope - 1.0) < SLOPE_TOLERANCE
    noisy = noise > 3.0 * max(step_y, _motion_left(target)) / np.sqrt(12.0)
    if is_difference and noisy and left < ROUNDING_FACTOR * rounding and noise_left < NOISE_FACTOR * noise:
        return Derivation(left, float(np.sqrt(np.mean((target - target.mean()) ** 2))))
    return None


def _longest(valid: Mask) -> slice:
    """Return the longest run of valid samples, cut to MAX_ROWS."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], valid.astype(np.int8), [0]))))
    if not len(edges):
        return slice(0, 0)
    starts, stops = edges[::2], edges[1::2]
    k = int(np.argmax(stops - starts))
    return slice(int(starts[k]), int(min(stops[k], starts[k] + MAX_ROWS)))


def _noise(values: Array) -> float:
    """Return the standard deviation of white noise that the sixth differences of the values would have."""
    return float(np.sqrt(np.mean(np.diff(values, NOISE_ORDER) ** 2) / 924.0))


def _motion_left(values: Array) -> float:
    """Return what a smooth oscillation leaves in `_noise`, from its strongest frequency."""
    centred = values - values.mean()
    power = np.abs(np.fft.rfft(centred * np.hanning(len(values)))) ** 2
    frequency = float(np.argmax(power[1:]) + 1) / len(values)
    return float(np.std(centred) * (2.0 * np.sin(np.pi * min(frequency, 0.5))) ** NOISE_ORDER / np.sqrt(924.0))
