"""Segments: a long record is fitted in pieces, each with a start of its own.

Over hundreds of cycles a clock, a temperature or a draught may move the phase by more than any force does, and a free
run from one start would take it for a force. Pieces share the physics and forgive the drift between them. A start
of its own costs a piece the phase that ties it to the others: the stiffness from p pieces is p times less certain than
from one. So pieces are as long as the phase keeps in step, which the record itself tells.

Phase drift: whether a long decay keeps in step with itself, or a clock, a warming or a draught moves its phase.

Whatever forces act, the frequency of a free decay is a function of its amplitude, and if they change, they change
slowly. Cycle by cycle, the phase less the integral of such a function is the noise of the readings, or it drifts.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from identify.arrays import Array
from identify.formatting import sentence_case
from identify.free_decay import FreeDecay
from identify.preprocessing.prepared_decay import PreparedDecay, prepare
from identify.preprocessing.usable import floor_of

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
    """Prepare one release or several where they are not yet, and cut long ones into segments."""
    return tuple(
        piece
        for release, prepared in enumerate(prepared_of(decays))
        for piece in segments(_counted(prepared, release))
    )


def prepared_of(
    decays: FreeDecay | PreparedDecay | Sequence[FreeDecay | PreparedDecay],
) -> tuple[PreparedDecay, ...]:
    """Prepare one release or several where they are not yet."""
    given = [decays] if isinstance(decays, FreeDecay | PreparedDecay) else decays
    return tuple(prepare(decay) if isinstance(decay, FreeDecay) else decay for decay in given)


def largest_first(decays: Sequence[PreparedDecay]) -> tuple[int, ...]:
    """Return the places of releases by falling amplitude, so that no result depends on the order they were given in."""
    return tuple(sorted(range(len(decays)), key=lambda i: -decays[i].amplitude))


def segments(prepared: PreparedDecay) -> tuple[PreparedDecay, ...]:
    """Cut a long release into segments that cover it without a gap; keep a short one whole.

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
    pieces = (part_of(prepared, slice(first, last)) for first, last in bounds)
    return tuple(replace(p, window=p.window.with_(segment=True), share=share) for p in pieces)


def what_was_used(pieces: Sequence[PreparedDecay]) -> str:
    """Say which readings of the free motion are fitted; "" where all are fitted as they were recorded.

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
    return f"{sentence_case('; '.join(words))}." if words else ""


def part_of(prepared: PreparedDecay, samples: slice) -> PreparedDecay:
    """Cut some samples out of a release, with a start of their own; only the first ones know the motion before."""
    window = prepared.window.part(samples)
    keep = np.arange(len(window)) >= window.lead
    return replace(
        prepared,
        window=window.with_(
            used={c: mask & keep for c, mask in window.used.items()},
            pre_release=None if samples.start else window.pre_release,
        ),
        motion=prepared.motion.part(samples),
        lost={c: mask[samples] for c, mask in prepared.lost.items()},
        rest=None if samples.start else prepared.rest,
    )


def first_cycles(prepared: PreparedDecay, cycles: float) -> PreparedDecay:
    """Cut the first cycles out of a release, or of a piece of one; keep it whole where it has no more."""
    samples = int(cycles * 2.0 * np.pi / prepared.frequency * prepared.window.rate)
    return prepared if samples >= len(prepared.window) else part_of(prepared, slice(samples))


def _counted(prepared: PreparedDecay, release: int) -> PreparedDecay:
    """Give a release its place among several; a piece has that of the release that it was cut from."""
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


_POWERS = (1.0, 2.0, 4.0, -1.0)
"""Of the amplitude, in the frequency: one-sided and hysteretic springs, cubic, quintic, play; dry friction has no share."""

_ENDS = 2
"""Cycles at either end of the motion that are not looked at."""

_NORMAL = 0.6745
"""Median of a standard normal variable's size: a jump of the phase is no drift."""

_SHARE_OF_NOISE = 0.3
"""A drift that moves the readings by this share of their noise raises a reduced chi-square by a twentieth."""


def drifts(prepared: PreparedDecay) -> bool:
    """Check whether the phase drifts from every law of the amplitude by more than a share of the readings' noise."""
    phase, amplitude = _phase_by_cycle(prepared)
    if len(phase) <= len(_POWERS) + 3:  # as many as the law has coefficients: nothing is left to stray
        return False
    cycles = np.arange(len(phase), dtype=np.float64)
    relative = amplitude / amplitude.max()
    columns = [np.ones_like(cycles), cycles, cycles**2]
    columns += [np.cumsum(relative**power) - 0.5 * relative**power for power in _POWERS]
    design = np.column_stack(columns) * relative[:, None]
    design /= np.linalg.norm(design, axis=0)
    left = phase * relative
    left = (left - design @ np.linalg.lstsq(design, left, rcond=1e-10)[0]) * amplitude.max()
    noise = floor_of(prepared.window.sigma, prepared.frequency)
    by_cycle = 2.0 * noise**2 / (2.0 * np.pi / prepared.frequency * prepared.motion.rate)
    strays = float(np.median(np.abs(left))) / _NORMAL
    return bool(strays**2 > by_cycle + (_SHARE_OF_NOISE * noise) ** 2)


def _phase_by_cycle(prepared: PreparedDecay) -> tuple[Array, Array]:
    """Return the mean phase (rad) beyond that of a steady rotation and the mean amplitude of each cycle, (cycles,)."""
    motion, w = prepared.motion, prepared.frequency
    quarter = motion.velocity / w
    phase = np.unwrap(np.arctan2(-quarter, motion.displacement))
    amplitude = np.hypot(motion.displacement, quarter)
    turns = np.maximum.accumulate((phase - phase[0]) / (2.0 * np.pi))
    cycle = np.floor(turns).astype(int)
    whole = cycle < cycle[-1]
    beyond = phase - w * np.arange(len(phase)) / motion.rate
    count = np.maximum(np.bincount(cycle[whole]), 1)
    inside = slice(_ENDS, -_ENDS)  # where the motion is read off both sides
    return (
        (np.bincount(cycle[whole], beyond[whole]) / count)[inside],
        (np.bincount(cycle[whole], amplitude[whole]) / count)[inside],
    )
