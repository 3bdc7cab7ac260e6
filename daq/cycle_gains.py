"""Each cycle against the one before: where the size or the sign of a channel changes from one reading to the next.

In a free oscillation the slope of a channel against itself a period earlier is positive and goes on smoothly, but for the
one period in which its gain or its sign changes.
"""

from dataclasses import dataclass

import numpy as np

from daq.recording import Array, Mask
from daq.smooth_course import spectrum

FEWEST, SHORTEST = 2.0, 6.0
"""Periods that half a record has at least, and readings that a period has."""
PIECES = 4
"""Windows of one period begin so many times a period."""
AGREE, SMALLEST = 0.35, 0.15
"""Share of the power that two periods have in common, and of the largest size, below which a window says nothing."""
SAME_PHASE = 0.85
"""The share that they have in common where only the size changed: a pause of the sampling moves the phase."""
GAIN_STEP, SCATTER = 0.25, 8.0
"""Logarithm of the smallest step that is looked for, and how many times a usual change it is."""
SMOOTH, STRAIGHT = 0.5, 0.3
"""In which share of windows at least a free oscillation grows or shrinks by less than this in a period (logarithm)."""


@dataclass(frozen=True)
class Step:
    """A jump of the gain at sample `index`: by this `factor`, or of its sign."""

    index: int
    factor: float
    reverses: bool


def cycle_length(channels: tuple[Array, ...]) -> float | None:
    """Return the period in samples at which all channels, shape (n,) each, oscillate; None where they hardly do.

    By the mean spectrum of halves of the record: a change of sign within it splits the line of the whole.
    """
    width = len(channels[0]) // 2
    if width < 16 or not all(np.ptp(x) > 0.0 for x in channels):
        return None
    size = 1 << (4 * width - 1).bit_length()
    common = np.ones(size // 2 + 1)
    for x in channels:
        halves = np.lib.stride_tricks.sliding_window_view(x / np.ptp(x), width)[:: width // 4]
        power = np.sum([spectrum(half, size) for half in halves], axis=0)
        common *= power / power.max()
    common[: round(FEWEST * size / width)] = 0.0
    peak = int(np.argmax(common))
    if not 0 < peak < len(common) - 1:
        return None
    left, top, right = np.sqrt(common[peak - 1 : peak + 2])
    bend = left - 2.0 * top + right
    period = size / (peak + (0.5 * float((left - right) / bend) if bend < 0.0 else 0.0))
    return period if period >= SHORTEST else None


@np.errstate(divide="ignore", invalid="ignore")  # where a channel stands still, its gain is unknown
def gain_steps(x: Array, period: float, moving: Mask) -> tuple[Step, ...]:
    """Find where the gain of a channel, shape (n,), jumps against itself a period earlier, while it is `moving`, (n,).

    There its slope differs from that both before and after, in phase or reversed.
    """
    span = np.flatnonzero(moving)
    if len(span) < 5.0 * period:
        return ()
    begin, end = int(span[0]), int(span[-1]) + 1
    whole = round(period)
    hop, apart = max(whole // PIECES, 1), round(1.5 * PIECES)
    pair = x[begin + whole : end], x[begin : end - whole]
    slope, in_phase = (_slopes(*pair, whole, hop, share) for share in (AGREE, SAME_PHASE))
    goes_on = np.abs(np.log(slope)) < STRAIGHT
    if goes_on.sum() < SMOOTH * len(slope):
        return ()
    middle, before, after = slope[apart:-apart], slope[: -2 * apart], slope[2 * apart :]
    change = np.log(np.abs(middle)) - 0.5 * (np.log(before) + np.log(after))
    smooth = np.isfinite(change) & goes_on[: -2 * apart] & goes_on[2 * apart :]
    reverses = smooth & (middle < 0.0)
    large = np.abs(change) > max(GAIN_STEP, SCATTER * _usual(slope))
    jumps = reverses | (smooth & large & np.isfinite(in_phase)[apart:-apart])
    found: list[Step] = []
    at = np.flatnonzero(jumps)
    for group in np.split(at, np.flatnonzero(np.diff(at) > apart) + 1) if len(at) else []:
        size = np.abs(change[group])
        top = group[reverses[group]] if reverses[group].any() else group[size >= 0.9 * size.max()]
        best = int(top[len(top) // 2])
        index = begin + whole + (best + apart) * hop
        found.append(Step(index, float(np.exp(change[best])), bool(reverses[group].any())))
    return tuple(found)


def _slopes(y: Array, x: Array, width: int, hop: int, share: float) -> Array:
    """Return the slope of y against x in windows, NaN where they hardly move or have less than this share in common."""
    view = np.lib.stride_tricks.sliding_window_view
    both = [
        part - part.mean(axis=1, keepdims=True) for part in (view(x, width)[::hop], view(y, width)[::hop])
    ]
    xx, xy, yy = (
        (a * b).sum(axis=1) for a, b in ((both[0], both[0]), (both[0], both[1]), (both[1], both[1]))
    )
    agree = (xy**2 > share * xx * yy) & (xx > SMALLEST**2 * xx.max()) & (yy > SMALLEST**4 * yy.max())
    return np.asarray(np.where(agree, xy / xx, np.nan))


def _usual(slope: Array) -> float:
    """Return the median change of the slope from a window to the one half a period later (logarithm)."""
    change = np.abs(np.diff(np.log(np.abs(slope[:: PIECES // 2])), 1))
    known = change[np.isfinite(change)]
    return float(np.median(known)) if len(known) else 0.0
