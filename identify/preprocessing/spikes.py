"""Spikes: single readings of a displacement that no motion can have made, as a sonar's drop-outs are."""

from itertools import pairwise

import numpy as np

from identify.arrays import Array, Mask
from identify.free_decay import FreeDecay
from identify.preprocessing.usable import valid_samples

_STENCIL = np.array([1.0, -4.0, 6.0, -4.0, 1.0]) / 6.0
_SPREAD = np.sqrt(70.0) / 6.0  # of the stencil's answer to white noise
_FAR = 8.0  # standard deviations that noise does not reach


def without_spikes(decay: FreeDecay) -> FreeDecay:
    """Return the decay with the spikes of its displacement marked as lost; unchanged when there are none.

    Accelerations are left alone: dry friction makes them jump, and so does a stop.
    """
    if decay.displacement is None:
        return decay
    valid = valid_samples(decay)
    spikes = find_spikes(decay.displacement[decay.release :], valid[decay.release :], decay.rate)
    if not np.any(spikes):
        return decay
    valid[decay.release :] &= ~spikes
    return decay.with_(valid=valid)


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
    floor = _resolution(samples[valid]) * _SPREAD / np.sqrt(12.0)
    limit = _FAR * np.maximum(np.interp(np.arange(len(size)), 0.5 * (edges[1:] + edges[:-1]), level), floor)
    out = np.flatnonzero(size > limit)
    for shift in range(5):
        spikes[out + shift] = True
    return spikes if np.mean(spikes) < 0.2 else np.zeros(n, dtype=np.bool_)


def _resolution(samples: Array) -> float:
    steps = np.diff(np.unique(samples))
    steps = steps[steps > 1e-9 * np.ptp(samples)] if len(steps) else steps
    return float(np.median(steps)) if len(steps) else 0.0
