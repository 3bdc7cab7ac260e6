"""Segments: a long record is fitted in pieces, each with a start of its own.

Over hundreds of cycles a clock, a temperature or a draught may move the phase by more than any force does, and a free
run from one start would take it for a force. Pieces share the physics and forgive the drift between them. A start
of its own costs a piece the phase that ties it to the others: the stiffness from p pieces is p times less certain than
from one. So pieces are as long as the phase keeps in step, which the record itself tells.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from identify.fitting.phase_walk import drifts
from identify.free_decay import FreeDecay
from identify.preprocessing.prepared_decay import PreparedDecay, prepare

_LONG_CYCLES = 60.0
_DRIFTING_CYCLES = 12.0
_SHORTEST_CYCLES = 4.0
_MOST = 6
"""Pieces: each has six unknowns of its own, and what they cost grows with the square of their number."""

_MOST_CYCLES = 240.0
"""Cycles that are simulated: a diagnosis takes as long as the cycles that it runs through a thousand times."""


def segments_of(
    decays: FreeDecay | PreparedDecay | Sequence[FreeDecay | PreparedDecay],
) -> tuple[PreparedDecay, ...]:
    """Return one release or several, prepared where they are not yet, long ones as their segments."""
    return tuple(
        piece
        for release, prepared in enumerate(prepared_of(decays))
        for piece in segments(_counted(prepared, release))
    )


def prepared_of(
    decays: FreeDecay | PreparedDecay | Sequence[FreeDecay | PreparedDecay],
) -> tuple[PreparedDecay, ...]:
    """Return one release or several, prepared where they are not yet."""
    given = [decays] if isinstance(decays, FreeDecay | PreparedDecay) else decays
    return tuple(prepare(decay) if isinstance(decay, FreeDecay) else decay for decay in given)


def largest_first(decays: Sequence[PreparedDecay]) -> tuple[int, ...]:
    """Return the places of releases by falling amplitude: what is said of them does not hang on how they were given."""
    return tuple(sorted(range(len(decays)), key=lambda i: -decays[i].amplitude))


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
    """Return a long release as segments that cover it without a gap; a short one as it is.

    Segments have 60 cycles, the last what remains; or, where the phase drifts, twelve cycles or more, all of one length,
    at most six of them. Of a release of more than 240 cycles as many are taken, spread evenly
    over it. A driven motion is kept in step by its force, and stays whole.
    """
    window, n = prepared.window, len(prepared.window)
    cycle = 2.0 * np.pi / prepared.frequency * window.rate
    if window.segment or window.force is not None or n / cycle < _LONG_CYCLES:
        return (prepared,)
    bounds = _bounds(n, cycle, drifting=drifts(prepared))
    share = sum(last - first for first, last in bounds) / n
    return tuple(_segment(prepared, first, last, share) for first, last in bounds)


def what_was_used(pieces: Sequence[PreparedDecay]) -> str:
    """Return which readings of the free motion are fitted, in a sentence; "" where all are, as they were recorded.

    How far into its record each release is used: `PreparedDecay.use`.
    """
    words = []
    if any(piece.block > 1 for piece in pieces):
        words.append(f"means of up to {max(piece.block for piece in pieces)} readings are fitted")
    cut = [piece for piece in pieces if piece.window.segment]
    if cut:
        share = float(np.mean([piece.share for piece in cut]))
        words.append(
            f"long records are fitted in pieces, {len(cut)} here, of {100.0 * share:.3g} % of their motion"
        )
    sentence = "; ".join(words)
    return f"{sentence[0].upper()}{sentence[1:]}." if sentence else ""


def first_cycles(prepared: PreparedDecay, cycles: float) -> PreparedDecay:
    """Return the first cycles of a release, or of a piece of one; as it is where it has no more."""
    samples = int(cycles * 2.0 * np.pi / prepared.frequency * prepared.window.rate)
    if samples >= len(prepared.window):
        return prepared
    kept = slice(samples)
    return replace(
        prepared,
        window=prepared.window.until(samples),
        motion=prepared.motion.part(kept),
        lost={c: m[kept] for c, m in prepared.lost.items()},
    )


def _counted(prepared: PreparedDecay, release: int) -> PreparedDecay:
    """Return a release with its place among several; a piece has that of the release that it was cut from."""
    window = prepared.window
    if window.segment or window.release == release:
        return prepared
    return replace(prepared, window=window.with_(release=release))


def _bounds(n: int, cycle: float, *, drifting: bool) -> list[tuple[int, int]]:
    """Return the first sample of each segment and one past its last."""
    if n / cycle > _MOST_CYCLES:
        count = _MOST if drifting else round(_MOST_CYCLES / _LONG_CYCLES)
        length = int(_MOST_CYCLES / count * cycle)
        return [(int(first), int(first) + length) for first in np.linspace(0, n - length, count)]
    if drifting:
        count = min(int(n / cycle / _DRIFTING_CYCLES), _MOST)
        return list(pairwise(np.linspace(0, n, count + 1).astype(int).tolist()))
    edges = np.arange(0.0, n - _SHORTEST_CYCLES * cycle, _LONG_CYCLES * cycle).astype(int).tolist()
    return list(pairwise([*edges, n]))


def _segment(prepared: PreparedDecay, first: int, last: int, share: float) -> PreparedDecay:
    samples = slice(first, last)
    window = prepared.window.part(samples)
    used = {c: m & (np.arange(last - first) >= window.lead) for c, m in window.used.items()}
    return replace(
        prepared,
        window=window.with_(used=used, pre_release=window.pre_release if first == 0 else None, segment=True),
        motion=prepared.motion.part(samples),
        lost={c: m[samples] for c, m in prepared.lost.items()},
        rest=prepared.rest if first == 0 else None,
        share=share,
    )
