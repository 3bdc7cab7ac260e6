"""Channels that the logger computed from another one, distinguished from sensors of their own.

A logger's derivative repeats the noise of its source, filtered: one fixed finite difference of the source
gives it to within the rounding of the numbers in the file. A second sensor has a noise of its own, which
nothing in the source predicts, so that its difference to the source's derivative is never less noisy than
itself. The differences that loggers use are tried.
"""

import numpy as np

from daq.importing.column_numbers import rounding
from daq.recording import Array, Mask, runs

STRAYS = 0.01  # of the samples: corrected by hand, or at the ends of a piece
MIN_ROWS = 40
MAX_ROWS = 40_000
NOISE_ORDER = 6
NOISE_SCALE = np.sqrt(924.0)  # of white noise of unit variance after six differences
FIRST = (
    (-1.0, 1.0, 0.0),
    (0.0, -1.0, 1.0),
    (-0.5, 0.0, 0.5),
    (-1 / 6, -1 / 6, 0.0, 1 / 6, 1 / 6),
    (1 / 12, -8 / 12, 0.0, 8 / 12, -1 / 12),
    *(tuple(3.0 * k / (m * (m + 1) * (2 * m + 1)) for k in range(-m, m + 1)) for m in (2, 3, 4, 5, 6)),
)


def find_derivation(
    source: Array,
    channel: Array,
    rate: float,
    order: int,
    stamps: Array | None = None,
    steps: tuple[Array, Array] | None = None,
) -> float | None:
    """Find out whether `channel` was computed as the derivative of that `order` of `source`; None if it was not, else the
    rms that the computation leaves, as a share of the channel's.

    All have shape (n,) and SI units; `stamps` (s) serve where they stray from the even clock of `rate` Hz, since
    a logger divides by its own time steps. `steps`, of shape (n,) each, are the steps to which the numbers of source
    and channel were rounded in the file, in SI units (found from the numbers where they are not given). None also when
    there are too few samples to decide.
    """
    stretch = _longest(np.isfinite(source) & np.isfinite(channel))
    if stretch.stop - stretch.start < MIN_ROWS:
        return None
    x, y = source[stretch], channel[stretch]
    if not (np.ptp(x) > 0.0 and np.ptp(y) > 0.0 and max(np.max(np.abs(x)), np.max(np.abs(y))) < 1e100):
        return None
    dx, dy = (step[stretch] for step in steps) if steps is not None else (rounding(x), rounding(y))
    for local in _local_steps(stamps[stretch], rate) if stamps is not None else (1.0,):
        for kernel in FIRST:
            found = _by_kernel(
                x, y * local**order, _power(kernel, order) * rate**order, (dx, dy), order, rate
            )
            if found is not None:
                return found
    return None


def _local_steps(stamps: Array, rate: float) -> tuple[Array, ...]:
    """Return the logger's own time step at each sample over the mean one: central, backward, forward."""
    steps = np.diff(stamps) * rate
    backward, forward = np.concatenate((steps[:1], steps)), np.concatenate((steps, steps[-1:]))
    return 0.5 * (backward + forward), backward, forward


def _power(kernel: tuple[float, ...], order: int) -> Array:
    """Return a first difference, or it applied twice; (1, -2, 1) is the backward one of the forward one."""
    first = np.array(kernel)
    if order == 1:
        return first
    twice = np.convolve(first, first)
    return (
        np.array([1.0, -2.0, 1.0]) if np.count_nonzero(first) == 2 and len(first) == 3 and first[1] else twice
    )


def _by_kernel(
    x: Array, y: Array, kernel: Array, steps: tuple[Array, Array], order: int, rate: float
) -> float | None:
    """Try one known difference: hardly a sample may be further off than rounding can put it, the gain must be 1, and
    either it explains the channel's noise or it shows the very droop and delay of this difference.
    """
    reach = len(kernel) // 2
    target = y[reach : len(y) - reach]
    made = np.convolve(x, kernel[::-1], "valid")
    residual = target - made
    own = steps[1][reach : len(y) - reach]
    limit = 0.5 * (np.convolve(steps[0], np.abs(kernel), "valid") + own)
    allowed = float(np.sqrt(np.mean(np.convolve(steps[0] ** 2, kernel**2, "valid") + own**2) / 12.0))
    step = _rms(own)
    inside = np.abs(residual) <= 1.01 * limit + 1e-12 * np.abs(target)
    power = float(target @ target)
    if power == 0.0 or np.mean(~inside) > STRAYS:
        return None
    left = _rms(residual[inside])
    if left > 1.15 * allowed + 1e-12 * _rms(target):
        return None
    gain_error = abs(float(target @ residual) / power)
    gain_std = left / np.sqrt(power)
    if gain_error > 5.0 * gain_std + 1e-3:
        return None
    noise = _noise(target)
    explains = _is_noisy(target, step) and _noise(residual) < 0.6 * noise
    droops = gain_error < 5.0 * gain_std and _departure(target, kernel, order, rate) > 12.0 * gain_std
    return left / _rms(target) if explains or droops else None


def _departure(values: Array, kernel: Array, order: int, rate: float) -> float:
    """Return the relative error of a difference as a derivative at the strongest frequency."""
    omega = 2.0 * np.pi * _frequency(values)
    shifts = np.arange(len(kernel)) - len(kernel) // 2
    response = complex(np.sum(kernel * np.exp(1j * omega * shifts)))
    return abs(response / ((1j * omega * rate) ** order) - 1.0) if omega > 0.0 else 0.0


def _longest(valid: Mask) -> slice:
    """Return the longest run of valid samples, cut to MAX_ROWS."""
    start, stop = max(runs(valid), key=lambda run: run[1] - run[0], default=(0, 0))
    return slice(start, min(stop, start + MAX_ROWS))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _noise(values: Array) -> float:
    """Return the standard deviation of the white noise that has the same sixth differences."""
    return float(np.sqrt(np.mean(np.diff(values, NOISE_ORDER) ** 2)) / NOISE_SCALE)


def _is_noisy(values: Array, step: float) -> bool:
    """Check whether sixth differences see noise: more than rounding and a smooth oscillation leave in them."""
    motion = float(np.std(values)) * (2.0 * np.sin(np.pi * _frequency(values))) ** NOISE_ORDER / NOISE_SCALE
    return bool(_noise(values) > 3.0 * max(step / np.sqrt(12.0), motion))


def _frequency(values: Array) -> float:
    """Return the strongest frequency, in cycles per sample, at most 0.5."""
    power = np.abs(np.fft.rfft((values - values.mean()) * np.hanning(len(values)))) ** 2
    return min(float(np.argmax(power[1:]) + 1) / len(values), 0.5)
