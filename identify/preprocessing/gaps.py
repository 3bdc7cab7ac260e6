"""Gaps: where readings are lost for so long that the motion across them is not seen, or not known."""

import numpy as np

from identify.arrays import Array, Mask

LONG_GAP = 0.5
"""Cycles of lost readings from which on they end an analysis: the motion across them is not known."""

LONG_LOSS = 0.33
"""Share of a cycle from which on lost samples are a hole in the running amplitude; shorter ones are bridged."""


def runs_of(mask: Mask) -> list[tuple[int, int]]:
    """Return where each run of marked samples begins, and one past its end."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def block_means(values: Array, step: int) -> Array:
    """Return the means of whole blocks of `step` samples."""
    count = len(values) // step
    means: Array = values[: count * step].reshape(count, step).mean(axis=1)
    return means


def over_gaps(amplitude: Array, lost: Mask, step: int, lap: int) -> Array:
    """Return a running amplitude with a straight line over long losses: it sees none of the motion in there.

    Of blocks of `step` samples; a loss is long from a third of a cycle (`lap` blocks), and is seen one cycle away.
    """
    blocks = block_means(lost.astype(float), step)[: len(amplitude)] > 0.5
    unseen = np.zeros(len(amplitude), dtype=bool)
    for begin, end in runs_of(blocks):
        if end - begin > LONG_LOSS * lap:
            unseen[max(begin - lap, 0) : end + lap] = True
    if not unseen.any() or unseen.all():
        return amplitude
    place = np.arange(len(amplitude))
    return np.where(unseen, np.interp(place, place[~unseen], amplitude[~unseen]), amplitude)


def first_gap(lost: Mask, start: int, period: float) -> int:
    """Return where readings are first lost for so long that the motion across is not known; the end where they are not."""
    gaps = (
        begin for begin, end in runs_of(lost) if begin > start + period and end - begin >= LONG_GAP * period
    )
    return next(gaps, len(lost))
