"""The noise level of one channel, where nobody has measured it."""

import numpy as np

from identify.arrays import Array, Mask


def noise_level(samples: Array, valid: Mask, fitted: Array | None = None) -> float:
    """Return an estimate of the white-noise standard deviation of `samples` (n,).

    The median fourth difference, which a motion of twenty samples a cycle or more leaves untouched; the rms of
    what `fitted` (n,) leaves, when that is smaller.
    """
    stencil = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
    usable = np.convolve(valid.astype(np.float64), np.ones(5), mode="valid") > 4.5
    candidates = []
    if np.any(usable):
        differences = np.convolve(np.where(valid, samples, 0.0), stencil, mode="valid")[usable]
        candidates.append(1.4826 * float(np.median(np.abs(differences))) / np.sqrt(70.0))
        candidates.append(float(np.sqrt(np.mean(differences**2) / 70.0)) / 3)
    if fitted is not None and np.any(valid):
        candidates.append(float(np.sqrt(np.mean((samples - fitted)[valid] ** 2))))
    return max(candidates[:2] or [0.0]) if len(candidates) < 3 else min(max(candidates[:2]), candidates[2])
