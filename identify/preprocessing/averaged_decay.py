"""The averaged decay: a record far faster than its motion, averaged to what a fit needs; no reading is thrown away.

A block's mean lags behind nothing, and what it loses of the motion is put back. With 64 blocks a cycle a third harmonic
still loses 3.2e-3 of itself, below the noise of a thousand readings. White noise falls with the root of the block's length.
"""

from dataclasses import replace

import numpy as np

from identify.free_decay import FreeDecay
from identify.preprocessing.aligned_decay import AlignedDecay
from identify.preprocessing.noise import Noise, noise_of
from identify.preprocessing.release import Release
from identify.preprocessing.sampling import average_blocks, blocks_held, flat_frequency

BLOCKS_A_CYCLE = 64
"""Blocks a cycle that a fit needs at least; the simulator takes twice as many steps."""

FEW = 4096
"""Samples of motion that are fitted as they are, however fast; an average leaves half as many at least."""

_DISAGREE = 4.0
"""Standard errors by which the noise of the blocks may differ from what white noise leaves."""


def averaged(aligned: AlignedDecay) -> tuple[AlignedDecay, int]:
    """Return an aligned decay with 64 to 128 samples a cycle, and how many readings make one; unchanged where few.

    Blocks begin at the release. Lost readings are bridged unless they are half of their block or more, which is then lost.
    The noise of the blocks is that of the readings over the root of their number, unless the blocks say otherwise:
    noise that is not white falls less.
    """
    record = aligned.recorded
    block, frequency = _block(record)
    if block < 2:
        return aligned, 1
    recorded, begins = average_blocks(record, block, frequency, aligned.lost)
    decay, _ = average_blocks(aligned.decay, block, frequency)
    noise = _noise(aligned.noise, recorded, block)
    std = {f"noise_{name}": max(found.std, 1e-300) for name, found in noise.items()}
    skipped = record.start % block
    lost = {name: ~blocks_held(~mask[skipped:], block) for name, mask in aligned.lost.items()}
    return replace(
        aligned,
        recorded=recorded.with_(**std),
        release=_release(aligned.release, recorded, begins, skipped, block),
        noise=noise,
        lost=lost,
        decay=decay.with_(**std),
    ), block


def _block(record: FreeDecay) -> tuple[int, float]:
    """Return how many readings make a block, and the frequency of the motion, Hz."""
    reading = next(iter(record.channels.values()))[record.start :]
    most = len(reading) // (FEW // 2)
    frequency = flat_frequency(reading, record.rate) if len(reading) > FEW else 0.0
    return min(int(record.rate / frequency / BLOCKS_A_CYCLE), most) if frequency > 0.0 else 1, frequency


def _noise(before: dict[str, Noise], recorded: FreeDecay, block: int) -> dict[str, Noise]:
    measured = noise_of(recorded)
    result = {}
    for name, raw in before.items():
        root = float(np.sqrt(block))
        white = Noise(raw.std / root, raw.uncertainty / root, raw.source)
        apart = abs(measured[name].std - white.std)
        doubt = float(np.hypot(measured[name].uncertainty, white.uncertainty))
        result[name] = measured[name] if apart > _DISAGREE * doubt else white
    return result


def _release(release: Release, recorded: FreeDecay, begins: float, skipped: int, block: int) -> Release:
    return replace(
        release,
        time_s=release.time_s - begins,
        index=recorded.start,
        settle=-(-(release.settle - skipped) // block),
        end=min(max((release.end - skipped) // block, 0), len(recorded)),
        rest=recorded.rest,
    )
