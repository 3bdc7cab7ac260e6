"""Thinning: a record with hundreds of samples a cycle, averaged in blocks to what the identification needs."""

import numpy as np

from identify.arrays import Array, Mask
from identify.free_decay import FreeDecay
from identify.preprocessing.usable import CHANNELS, valid_samples
from identify.signal.oscillation import dominant_frequency

_ENOUGH = 256  # samples a cycle; a block's mean is then 2.5e-5 smaller than its middle


def thinned(decay: FreeDecay) -> tuple[FreeDecay, float]:
    """Return the decay with at most some 500 samples a cycle, and the time of its first sample, s.

    Blocks start at the release; a block with a lost sample is lost; white noise shrinks with the root of the
    block's length. Unchanged, with 0 s, when it is slow enough already.
    """
    first = next(getattr(decay, name) for name in CHANNELS if getattr(decay, name) is not None)
    frequency = flat_frequency(first[decay.release :], decay.rate)
    block = int(decay.rate / frequency / _ENOUGH) if frequency > 0 else 1
    if block < 2:
        return decay, 0.0
    skipped = decay.release % block
    count = (len(decay) - skipped) // block

    def blocks(values: Array | Mask) -> Array:
        return np.asarray(values[skipped : skipped + count * block].reshape(count, block))

    changes: dict[str, object] = {
        "rate": decay.rate / block,
        "release": (decay.release - skipped) // block,
        "rest": (-(-max(decay.rest[0] - skipped, 0) // block), max(decay.rest[1] - skipped, 0) // block),
        "valid": np.all(blocks(valid_samples(decay)), axis=1),
    }
    for name in (*CHANNELS, "force"):
        if getattr(decay, name) is not None:
            changes[name] = blocks(getattr(decay, name)).mean(axis=1)
    for name in CHANNELS:
        noise = getattr(decay, f"noise_{name}")
        changes[f"noise_{name}"] = None if noise is None else noise / np.sqrt(block)
    return decay.with_(**changes), (skipped + 0.5 * (block - 1)) / decay.rate


def flat_frequency(values: Array, rate: float) -> float:
    """Return the dominant frequency (Hz) of a free motion, every frequency weighing the same; 0.0 without one."""
    finite = np.isfinite(values)
    if not np.any(finite):
        return 0.0
    return dominant_frequency(np.where(finite, values, np.mean(values[finite])), rate, derivative=2)
