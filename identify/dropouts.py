"""Dropouts: readings that stand still, fall to zero, or fly off while the motion runs on."""

import numpy as np

from identify.arrays import Array, Mask

_LONGEST = 12
_FAR = 8.0
_SPIKE = 14.0
_SPIKE_SHARE = 0.08


def find_dropouts(readings: Array, sigma: float) -> Mask:
    """Return which readings of a channel cannot be its sensor's answer to a smooth motion, shape (n,).

    A reading is lost when it repeats the one before it exactly, or is exactly zero, and lies more than eight noise
    standard deviations from the cubic through its neighbours; or when it stands alone, far off both neighbours.
    """
    n = len(readings)
    lost = np.zeros(n, dtype=np.bool_)
    suspicious = stale(readings)
    start = 2
    edges = np.flatnonzero(np.diff(np.concatenate([[0], suspicious.astype(np.int8), [0]])))
    for first, stop in edges.reshape(-1, 2):
        if first < start or stop + 2 > n or stop - first > _LONGEST:
            continue
        around = np.array([first - 2, first - 1, stop, stop + 1])
        inside = np.arange(first, stop)
        off = np.abs(readings[inside] - _cubic(around, readings[around], inside))
        if off.max() > _FAR * sigma:
            lost[inside] = True
    return lost | _spikes(readings, sigma, lost)


def stale(readings: Array) -> Mask:
    """Return which readings repeat the one before exactly, or are exactly zero, shape (n,)."""
    mask = np.asarray(readings == 0.0)
    mask[1:] |= readings[1:] == readings[:-1]
    return mask


def _cubic(at: Array, values: Array, where: Array) -> Array:
    result = np.zeros(len(where))
    for i in range(len(at)):
        others = np.delete(at, i)
        result += values[i] * np.prod((where[:, None] - others) / (at[i] - others), axis=1)
    return result


def _spikes(readings: Array, sigma: float, lost: Mask) -> Mask:
    """Return single readings that the cubic through their four neighbours misses by far."""
    off = np.zeros(len(readings))
    off[2:-2] = (
        readings[2:-2] - (-readings[:-4] + 4.0 * (readings[1:-3] + readings[3:-1]) - readings[4:]) / 6.0
    )
    limit = max(_SPIKE * sigma, _SPIKE_SHARE * float(np.ptp(readings)) / 2.0)
    size = np.abs(off)
    alone = np.zeros(len(readings), dtype=np.bool_)
    alone[1:-1] = (size[1:-1] > limit) & (size[1:-1] > 1.2 * np.maximum(size[:-2], size[2:]))
    return alone & ~lost
