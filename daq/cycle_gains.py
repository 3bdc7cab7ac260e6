"""Each cycle against its neighbours: by how much, and with which sign, a channel answers to the motion.

About a spring's rest the acceleration is the displacement times minus the frequency's square, whatever the mass does: the
slope of one channel against the other goes on smoothly from window to window, and a jump of it is a sensor's. One channel
alone is held against itself a period earlier: in a free oscillation that slope is positive and goes on smoothly as well, but
for the one period in which its gain or its sign changes.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from daq.recording import Array, Mask

FEWEST, SHORTEST = 2.0, 6.0
"""Periods that half a record has at least, and readings that a period has."""
PIECES = 4
"""Windows of one period begin so many times a period."""
AGREE, ALONE_AGREE = 0.94, 0.35
SMALLEST = 0.15
"""Share of two channels' power that they have in common, and of the largest size, below which a window says nothing."""
SAME_PHASE = 0.85
"""The share that one channel and itself a period earlier have in common where only its size changed: a pause of the
sampling moves its phase."""
GAIN_STEP, ALONE_STEP = 0.15, 0.25
SCATTER, USUAL = 8.0, 0.4
"""Logarithm of the smallest step that is looked for, with two channels and with one; times a usual one."""
SMOOTH, STRAIGHT = 0.5, 0.3
"""In which share of windows at least a free oscillation grows or shrinks by less than this in a period (logarithm)."""


@dataclass(frozen=True)
class Step:
    """A jump of the gain at sample `index`: by this `factor`, or of its sign."""

    index: int
    factor: float
    reverses: bool

    @property
    def inverse(self) -> "Step":
        """The same jump, of the other channel."""
        return Step(self.index, 1.0 / self.factor, self.reverses)


def cycle_length(channels: tuple[Array, ...]) -> float | None:
    """Return the period in samples at which all channels, shape (n,) each, oscillate; None where they hardly do.

    By the mean spectrum of halves of the record: a change of sign within it splits the line of the whole.
    """
    width = len(channels[0]) // 2
    if width < 16 or not all(np.ptp(x) > 0.0 for x in channels):
        return None
    size = 1 << (4 * width - 1).bit_length()
    place, window = np.linspace(-1.0, 1.0, width), np.hanning(width)
    common = np.ones(size // 2 + 1)
    for x in channels:
        power = np.zeros(size // 2 + 1)
        for first in range(0, len(x) - width + 1, max(width // 4, 1)):
            part = (x[first : first + width] - x[first : first + width].mean()) / np.ptp(x)
            part = part - place * float(part @ place) / float(place @ place)
            power += np.abs(np.fft.rfft(part * window, size)) ** 2
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
def gain_steps(x: Array, other: Array | None, period: float, moving: Mask) -> tuple[Step, ...]:
    """Find where the gain of `x` jumps against `other`, or against itself a period earlier, while it is `moving`, (n,)."""
    span = np.flatnonzero(moving)
    if len(span) < 5.0 * period:
        return ()
    begin, end = int(span[0]), int(span[-1]) + 1
    whole = round(period)
    hop = max(whole // PIECES, 1)
    if other is not None:
        slope = _slopes(x[begin:end], other[begin:end], whole, hop, AGREE)
        return _steps(slope, begin + whole // 2, round(1.5 * PIECES), hop)
    pair = x[begin + whole : end], x[begin : end - whole]
    slope, in_phase = (_slopes(*pair, whole, hop, share) for share in (ALONE_AGREE, SAME_PHASE))
    return _blips(slope, np.isfinite(in_phase), begin + whole, round(1.5 * PIECES), hop)


def own_change(x: Array, index: int, period: float) -> float:
    """Measure how much a channel differs after reading `index` from whole periods before: 0 for one that goes on."""
    gap, whole = round(0.25 * period), round(period)
    after = x[index + gap : index + gap + whole]
    before = x[max(index + gap - 2 * whole, 0) :][: len(after)]
    after, before = after - after.mean(), before - before.mean()
    return float(after @ before / (before @ before)) - 1.0


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


def _steps(slope: Array, first: int, apart: int, hop: int) -> tuple[Step, ...]:
    """Find where the slope differs between windows before and after a reading, the largest of each group."""
    if len(slope) <= apart:
        return ()
    change = np.log(np.abs(slope[apart:] / slope[:-apart]))
    reverses = slope[apart:] * slope[:-apart] < 0.0
    change -= 0.5 * (
        _shifted(change, apart) + _shifted(change, -apart)
    )  # what goes on before and after is no step
    known = np.isfinite(change)
    if not known.any():
        return ()
    usual = float(np.quantile(np.abs(change[known]), USUAL))
    jumps = known & ((np.abs(change) > max(GAIN_STEP, SCATTER * usual)) | reverses)
    jumps[: int(np.argmin(jumps))] = False  # the motion's beginning is no step within it
    return _found(jumps, change, reverses, lambda at: first + round((at + 0.5 * apart) * hop), apart)


def _usual(slope: Array) -> float:
    """Return the median change of the slope from a window to the one half a period later (logarithm)."""
    change = np.abs(np.diff(np.log(np.abs(slope[:: PIECES // 2])), 1))
    known = change[np.isfinite(change)]
    return float(np.median(known)) if len(known) else 0.0


def _shifted(change: Array, by: int) -> Array:
    """Return the change so many windows later, 0 where there is none or it is not known, (n,)."""
    out = np.zeros(len(change))
    if by > 0:
        out[:-by] = change[by:]
    else:
        out[-by:] = change[:by]
    return np.nan_to_num(out)


def _blips(slope: Array, in_phase: Mask, first: int, apart: int, hop: int) -> tuple[Step, ...]:
    """Find where the slope against a period earlier differs from that both before and after, `in_phase` or reversed."""
    if len(slope) <= 2 * apart:
        return ()
    middle, before, after = slope[apart:-apart], slope[: -2 * apart], slope[2 * apart :]
    around = np.log(before), np.log(after)
    change = np.log(np.abs(middle)) - 0.5 * (around[0] + around[1])
    goes_on = np.abs(np.log(slope)) < STRAIGHT
    smooth = goes_on[: -2 * apart] & goes_on[2 * apart :]
    known = np.isfinite(change)
    if goes_on.sum() < SMOOTH * len(slope):
        return ()
    reverses = known & smooth & (middle < 0.0)
    usual = _usual(slope)
    large = in_phase[apart:-apart] & (np.abs(change) > max(ALONE_STEP, SCATTER * usual))
    jumps = known & smooth & (large | reverses)
    return _found(jumps, change, reverses, lambda at: first + (at + apart) * hop, apart)


def _found(
    jumps: Mask, change: Array, reverses: Mask, index: Callable[[int], int], apart: int
) -> tuple[Step, ...]:
    found: list[Step] = []
    at = np.flatnonzero(jumps)
    for group in np.split(at, np.flatnonzero(np.diff(at) > apart) + 1) if len(at) else []:
        size = np.abs(change[group])
        top = group[reverses[group]] if reverses[group].any() else group[size >= 0.9 * size.max()]
        best = int(top[len(top) // 2])
        found.append(Step(index(best), float(np.exp(change[best])), bool(reverses[group].any())))
    return tuple(found)
