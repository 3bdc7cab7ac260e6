"""Lost readings: they stand still, fall to zero, or fly off while the motion runs on."""

from functools import lru_cache
from itertools import pairwise

import numpy as np

from identify.arrays import Array, Mask, frozen
from identify.preprocessing.noise import converter_step, stale, steps_between
from identify.signal.fractional_delay import lagrange_weights
from identify.signal.running import runs_of

_STENCIL = np.array([1.0, -4.0, 6.0, -4.0, 1.0]) / 6.0
_STENCIL_SPREAD = np.sqrt(70.0) / 6.0
"""Standard deviation of the fourth difference of white noise, over that of the noise."""

_LONGEST = 12
_FAR = 8.0
_USUAL = 0.75
_UNUSUAL = 6.0
_SPIKE = 14.0
_SPIKE_SHARE = 0.08


def find_lost_readings(readings: Array, sigma: float) -> Mask:
    """Return which readings of a channel cannot be its sensor's answer to a smooth motion, shape (n,).

    A reading is lost when it repeats the one before it exactly, or is exactly zero, and lies more than eight noise
    standard deviations (for a run of readings more, as the cubic's own error grows with its length) from the cubic through
    its neighbours, and farther than readings usually do where the motion is quick for the rate; or when it stands alone, far
    off both neighbours.
    """
    n = len(readings)
    lost = np.zeros(n, dtype=np.bool_)
    start, step = 2, converter_step(readings)
    by_length: dict[int, tuple[Array, float]] = {}
    for first, stop in runs_of(stale(readings)):
        if first < start or stop + 2 > n or stop - first > _LONGEST:
            continue
        length = stop - first
        if length not in by_length:
            off = _off_cubic(readings, length)
            usual, far = float(np.quantile(off, _USUAL)), _FAR * max(sigma, 0.5 * step) * _amplified(length)
            by_length[length] = off, far if usual < far else _UNUSUAL * usual
        off, limit = by_length[length]
        if off[first - 2] <= limit:
            continue
        sides = _off_line(readings, first, length), _off_line(readings[::-1], n - stop, length)
        lost[first:stop] = min(sides) > limit
    return lost | single_spikes(readings, sigma)


def _off_cubic(readings: Array, length: int) -> Array:
    """Return the largest distance of each run of readings from the cubic through two on either side, (n - length - 3,)."""
    windows = np.lib.stride_tricks.sliding_window_view(readings, length + 4)
    around = windows[:, [0, 1, -2, -1]]
    return np.asarray(np.abs(windows[:, 2:-2] - around @ _cubic(length)).max(axis=1))


def _off_line(readings: Array, first: int, length: int) -> float:
    """Return the largest distance of a run of readings from the line of those before it, over as long a stretch."""
    reach = min(length + 1, first - 1)
    end = readings[first - 1]
    line = end + (end - readings[first - 1 - reach]) / reach * np.arange(1.0, length + 1.0)
    return float(np.abs(readings[first : first + length] - line).max())


@lru_cache(maxsize=_LONGEST)
def _cubic(length: int) -> Array:
    """Return the weights of two readings on either side of a run in the cubic through them, shape (4, length)."""
    return frozen(lagrange_weights(np.array([-2.0, -1.0, length, length + 1.0]), np.arange(float(length))))


def _amplified(length: int) -> float:
    """Return the scatter of a run of readings about the cubic through its neighbours, over that of one reading."""
    spread = [np.sqrt(1.0 + np.max(np.sum(_cubic(n) ** 2, axis=0))) for n in (length, 1)]
    return float(spread[0] / spread[1])


def single_spikes(readings: Array, sigma: float) -> Mask:
    """Return single readings that the cubic through their four neighbours misses by far.

    The cubics of the neighbours, which lean on such a reading, miss them on the other side; a quick motion does not.
    """
    off = np.zeros(len(readings))
    off[2:-2] = (
        readings[2:-2] - (-readings[:-4] + 4.0 * (readings[1:-3] + readings[3:-1]) - readings[4:]) / 6.0
    )
    size = np.abs(off)
    usual = float(np.quantile(size, _USUAL))
    limit = max(_SPIKE * sigma, _UNUSUAL * usual, _SPIKE_SHARE * float(np.ptp(readings)) / 2.0)
    alone = np.zeros(len(readings), dtype=np.bool_)
    alone[1:-1] = (size[1:-1] > limit) & (size[1:-1] > 1.2 * np.maximum(size[:-2], size[2:]))
    alone[1:-1] &= (off[1:-1] * off[:-2] < 0.0) & (off[1:-1] * off[2:] < 0.0)
    return alone


def find_spikes(samples: Array, valid: Mask, rate: float) -> Mask:
    """Return the mask of samples (n,) that stand out of their four neighbours, with those neighbours.

    The measure is the fourth difference against eight times its typical size near by (half a hundred samples), which noise
    of any level and motion of any amplitude give themselves.
    """
    n = len(samples)
    spikes = np.zeros(n, dtype=np.bool_)
    if n < 64:
        return spikes
    usable = np.convolve(valid, np.ones(5), mode="valid") > 4.5
    size = np.where(usable, np.abs(np.convolve(np.where(valid, samples, 0.0), _STENCIL, mode="valid")), 0.0)
    block = max(50, int(rate * 0.25))
    blocks = max(1, len(size) // block)
    edges = np.linspace(0, len(size), blocks + 1).astype(int)
    typical = np.array([np.median(size[a:b]) for a, b in pairwise(edges)])
    level = np.maximum(typical, np.median(typical)) / 0.6745
    steps = steps_between(samples[valid])
    step = float(np.median(steps)) if len(steps) else 0.0
    floor = step * _STENCIL_SPREAD / np.sqrt(12.0)
    limit = _FAR * np.maximum(np.interp(np.arange(len(size)), 0.5 * (edges[1:] + edges[:-1]), level), floor)
    out = np.flatnonzero(size > limit)
    for shift in range(5):
        spikes[out + shift] = True
    return spikes if np.mean(spikes) < 0.2 else np.zeros(n, dtype=np.bool_)
