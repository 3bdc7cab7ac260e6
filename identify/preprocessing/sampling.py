"""How often a motion is sampled: too seldom to know its velocity, with gaps, or so often that blocks are averaged."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from identify.arrays import Array, Mask
from identify.formatting import two_figures
from identify.free_decay import FreeDecay
from identify.preprocessing.noise import noise_levels
from identify.signal.fractional_delay import bridge
from identify.signal.oscillation import dominant_frequency
from identify.signal.running import runs_of

_TOO_FEW = 8.0
"""Readings a cycle below which a refusal is put down to the sampling."""

_ENOUGH = 20.0
_AROUND = 0.1
_MOST_OF_IT = 0.5
"""A motion is an oscillation where so much of its power lies within so much of one frequency."""

_DRIFT, _PART_OF_ALL = 2, 0.2
"""Cycles in the record up to which power is a drift's; share of the rest below which a ripple is on a slower motion."""


def too_coarse(values: Array, rate: float, derivative: int) -> str:
    """Say why an oscillation cannot be followed at its `rate` (Hz); "" where it can.

    `values` (n,) are readings of the displacement or of one of its derivatives.
    """
    frequency = dominant_frequency(values, rate, derivative)
    if frequency <= 0.0 or rate >= _TOO_FEW * frequency or not _oscillates(values, rate, frequency):
        return ""
    a_cycle = two_figures(rate / frequency)
    return (
        f"The record has {rate:.3g} readings a second of a motion at about {two_figures(frequency)} Hz, {a_cycle} a "
        f"cycle: too few to follow it. Record at {max(round(_ENOUGH * frequency), 1)} Hz or faster."
    )


def _oscillates(values: Array, rate: float, frequency: float) -> bool:
    power = np.abs(np.fft.rfft((values - np.mean(values)) * np.hanning(len(values)))) ** 2
    bins = np.fft.rfftfreq(len(values), 1.0 / rate)
    near = float(power[np.abs(bins - frequency) < _AROUND * frequency].sum())
    quick, swinging = float(power[bins > 0.3 * frequency].sum()), float(power[_DRIFT + 1 :].sum())
    return near > max(_MOST_OF_IT * quick, _PART_OF_ALL * swinging, 1e-300)


LONG_GAP = 0.5
"""Cycles of lost readings from which on they end an analysis: the motion across them is not known."""

LONG_LOSS = 0.33
"""Share of a cycle from which on lost samples are a hole in the running amplitude; shorter ones are bridged."""

_HELD = 0.5
"""Share of a block's readings that must be there; the others are bridged."""

ENOUGH = 256
"""Samples a cycle that identification needs."""


def block_means(values: Array | Mask, step: int) -> Array:
    """Return the means of whole blocks of `step` samples, of a mask the shares."""
    count = len(values) // step
    return np.asarray(values[: count * step].reshape(count, step).mean(axis=1))


def blocks_held(known: Mask, block: int) -> Mask:
    """Return which whole blocks of `block` readings are known: half of each at least, and none beside a loss as long.

    What is bridged of a short loss is as good as read; of a long one it is not.
    """
    long = np.zeros(len(known), dtype=bool)
    for begin, end in runs_of(~known):
        long[begin:end] = end - begin >= block
    return np.asarray((block_means(known, block) > _HELD) & (block_means(long, block) == 0.0))


def over_gaps(amplitude: Array, lost: Mask, step: int, lap: int) -> Array:
    """Return a running amplitude with a straight line over long losses: it sees none of the motion in there.

    Of blocks of `step` samples; a loss is long from a third of a cycle (`lap` blocks), and is seen one cycle away.
    """
    blocks = block_means(lost, step)[: len(amplitude)] > 0.5
    unseen = np.zeros(len(amplitude), dtype=bool)
    for begin, end in runs_of(blocks):
        if end - begin > LONG_LOSS * lap:
            unseen[max(begin - lap, 0) : end + lap] = True
    if not unseen.any() or unseen.all():
        return amplitude
    place = np.arange(len(amplitude))
    return np.where(unseen, np.interp(place, place[~unseen], amplitude[~unseen]), amplitude)


def first_gap(lost: Mask, start: int, period: float) -> int:
    """Find the first gap of readings so long that the motion across it is not known; the end where there is none."""
    gaps = (
        begin for begin, end in runs_of(lost) if begin > start + period and end - begin >= LONG_GAP * period
    )
    return next(gaps, len(lost))


def block_averaged(decay: FreeDecay) -> tuple[FreeDecay, float]:
    """Return the decay with at most twice `ENOUGH` samples a cycle, and the time of its first sample, s.

    Unchanged, with 0 s, when it is slow enough already.
    """
    first = next(iter(decay.channels.values()))
    frequency = flat_frequency(first[decay.start :], decay.rate)
    return average_blocks(decay, int(decay.rate / frequency / ENOUGH) if frequency > 0 else 1, frequency)


def average_blocks(
    decay: FreeDecay, block: int, frequency: float, lost: Mapping[str, Mask] = MappingProxyType({})
) -> tuple[FreeDecay, float]:
    """Return the decay averaged over blocks of `block` samples, and the time of its first sample, s.

    Blocks start at the release. What a mean loses of a motion at `frequency` (Hz) is put back: uncorrected, dry friction
    would be as much too small as the amplitude (4e-4 with 64 blocks a cycle). Samples that are not known, or `lost` in
    one channel, are bridged as far as they are short. White noise shrinks with the root of the block's length.
    """
    if block < 2:
        return decay, 0.0
    skipped, known = decay.start % block, decay.known
    held = blocks_held(known[skipped:], block)
    changes: dict[str, object] = {
        "rate": decay.rate / block,
        "rate_std": None if decay.rate_std is None else decay.rate_std / block,
        "release": (decay.start - skipped) // block,
        "rest": (-(-max(decay.rest[0] - skipped, 0) // block), max(decay.rest[1] - skipped, 0) // block),
        "valid": None if held.all() else held,
    }
    forces = {} if decay.force is None else {"force": decay.force}
    kept = float(np.sinc(block * frequency / decay.rate) / np.sinc(frequency / decay.rate))
    for name, values in (decay.channels | forces).items():
        means = block_means(bridge(values, known & ~lost.get(name, ~known))[skipped:], block)
        moving = means[(decay.start - skipped) // block :]  # a rest has nothing to lose
        if len(moving):
            moving += (moving - np.mean(moving)) * (1.0 / kept - 1.0)
        changes[name] = means
    changes |= {f"noise_{name}": level / np.sqrt(block) for name, level in noise_levels(decay).items()}
    return decay.with_(**changes), (skipped + 0.5 * (block - 1)) / decay.rate


def flat_frequency(values: Array, rate: float) -> float:
    """Return the dominant frequency (Hz) of a free motion, every frequency weighing the same; 0.0 without one."""
    finite = np.isfinite(values)
    if not np.any(finite):
        return 0.0
    return dominant_frequency(np.where(finite, values, np.mean(values[finite])), rate, derivative=2)
