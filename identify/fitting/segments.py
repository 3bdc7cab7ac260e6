"""Segments: a long record is fitted in pieces, each with a start of its own.

Over hundreds of cycles a clock, a temperature or a draught moves the phase by more than any force does, and a free
run from one start would take it for a force. Pieces of a dozen cycles, spread over the decay, share the
physics and forgive the wandering between them.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from identify.free_decay import FreeDecay
from identify.preprocessing.prepared_decay import PreparedDecay, prepare

_LONG_CYCLES = 60.0
_SEGMENT_CYCLES = 12.0
_MOST = 6


def segments_of(
    decays: FreeDecay | PreparedDecay | Sequence[FreeDecay | PreparedDecay],
) -> tuple[PreparedDecay, ...]:
    """Return one release or several, prepared where they are not yet, long ones as their segments."""
    return tuple(piece for prepared in prepared_of(decays) for piece in segments(prepared))


def prepared_of(
    decays: FreeDecay | PreparedDecay | Sequence[FreeDecay | PreparedDecay],
) -> tuple[PreparedDecay, ...]:
    """Return one release or several, prepared where they are not yet."""
    given = [decays] if isinstance(decays, FreeDecay | PreparedDecay) else decays
    return tuple(prepare(decay) if isinstance(decay, FreeDecay) else decay for decay in given)


def segments_by_release(decays: Sequence[PreparedDecay]) -> tuple[tuple[int, ...], ...]:
    """Return, for each release, the places that its segments have in `segments_of`."""
    found: list[tuple[int, ...]] = []
    first = 0
    for prepared in decays:
        last = first + len(segments(prepared))
        found.append(tuple(range(first, last)))
        first = last
    return tuple(found)


def segments(prepared: PreparedDecay) -> tuple[PreparedDecay, ...]:
    """Return a long release as up to six segments spread evenly over it; a short one as it is.

    A driven motion is kept in step by its force, and stays whole.
    """
    window, n = prepared.window, len(prepared.window)
    cycle = 2.0 * np.pi / prepared.frequency * window.rate
    if window.force is not None or n / cycle < _LONG_CYCLES:
        return (prepared,)
    length = int(_SEGMENT_CYCLES * cycle)
    starts = np.linspace(0, n - length, _MOST).astype(int)
    return tuple(_segment(prepared, int(first), length) for first in starts)


def _segment(prepared: PreparedDecay, first: int, length: int) -> PreparedDecay:
    samples = slice(first, first + length)
    window = prepared.window.part(samples)
    used = {c: m & (np.arange(length) >= window.lead) for c, m in window.used.items()}
    return replace(
        prepared,
        window=window.with_(used=used, pre_release=window.pre_release if first == 0 else None, segment=True),
        motion=prepared.motion.part(samples),
        lost={c: m[samples] for c, m in prepared.lost.items()},
        rest=prepared.rest if first == 0 else None,
    )
