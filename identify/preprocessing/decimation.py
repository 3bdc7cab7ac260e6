"""Block averages: a record with more samples a cycle than a step needs, averaged to what it needs."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from identify.arrays import Array, Mask
from identify.free_decay import FreeDecay
from identify.preprocessing.noise import noise_levels
from identify.preprocessing.sampling import block_means
from identify.signal.fractional_delay import bridge
from identify.signal.oscillation import dominant_frequency

HELD = 0.5
"""Share of a block's readings that must be there; the others are bridged."""

ENOUGH = 256
"""Samples a cycle that identification needs; a block's mean is then 2.5e-5 smaller than its middle."""


def block_averaged(decay: FreeDecay) -> tuple[FreeDecay, float]:
    """Return the decay with at most twice `ENOUGH` samples a cycle, and the time of its first sample, s.

    Unchanged, with 0 s, when it is slow enough already.
    """
    first = next(iter(decay.channels.values()))
    frequency = flat_frequency(first[decay.start :], decay.rate)
    return average_blocks(decay, int(decay.rate / frequency / ENOUGH) if frequency > 0 else 1)


def average_blocks(
    decay: FreeDecay, block: int, lost: Mapping[str, Mask] = MappingProxyType({})
) -> tuple[FreeDecay, float]:
    """Return the decay averaged over blocks of `block` samples, and the time of its first sample, s.

    Blocks start at the release. Samples that are not known, or `lost` in one channel, are bridged; a block of which half is
    not known is not known. White noise shrinks with the root of the block's length.
    """
    if block < 2:
        return decay, 0.0
    skipped, known = decay.start % block, decay.known
    held = block_means(known[skipped:], block) > HELD
    changes: dict[str, object] = {
        "rate": decay.rate / block,
        "rate_std": None if decay.rate_std is None else decay.rate_std / block,
        "release": (decay.start - skipped) // block,
        "rest": (-(-max(decay.rest[0] - skipped, 0) // block), max(decay.rest[1] - skipped, 0) // block),
        "valid": None if held.all() else held,
    }
    forces = {} if decay.force is None else {"force": decay.force}
    changes |= {
        name: block_means(bridge(values, known & ~lost.get(name, ~known))[skipped:], block)
        for name, values in (decay.channels | forces).items()
    }
    changes |= {f"noise_{name}": level / np.sqrt(block) for name, level in noise_levels(decay).items()}
    return decay.with_(**changes), (skipped + 0.5 * (block - 1)) / decay.rate


def flat_frequency(values: Array, rate: float) -> float:
    """Return the dominant frequency (Hz) of a free motion, every frequency weighing the same; 0.0 without one."""
    finite = np.isfinite(values)
    if not np.any(finite):
        return 0.0
    return dominant_frequency(np.where(finite, values, np.mean(values[finite])), rate, derivative=2)
