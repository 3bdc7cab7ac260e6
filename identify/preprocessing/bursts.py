"""Bursts: the oscillations of a record that last, from where each may have begun to where it is over."""

from typing import NamedTuple

import numpy as np

from identify.arrays import Array, Mask
from identify.preprocessing.sampling import block_means, first_gap, over_gaps
from identify.signal.oscillation import running_amplitude, unfree
from identify.signal.running import running_median, runs_of

UNFREE_SHARE = 0.35
"""A force beyond the springs' of this share of theirs is a hand: friction and damping are far smaller."""

LAST_CYCLES, TAKEN_FOR = 4.5, 0.25
"""Cycles before the end of a burst in which a hand may take the mass again, and how long it does, in cycles, at least."""

POINTS_PER_PERIOD = 48
"""The coarse search looks at block means of about this many samples a period."""


class Channel(NamedTuple):
    """A channel without its spikes: a motion or its derivative of some order, the noise, and where readings are lost."""

    values: Array
    derivative: int
    noise: float
    lost: Mask


_MIRRORED = 3.0
"""Ratio of the times of fall and rise around the node of a beat up to which they are alike."""


class Burst(NamedTuple):
    """A sustained oscillation, in samples: where it may have begun and where it had died or the next one begins.

    It is `mirrored` where the one before it fell in about the time in which it rises, as around the node of a beat.
    """

    start: int
    stop: int
    amplitude: float
    mirrored: bool = False


def find_bursts(lead: Channel, period: float) -> list[Burst]:
    """Find sustained oscillations by their running amplitude: a steep rise, then more than a pulse."""
    coarse, step, turn = coarse_means(lead, period)
    n, lap = len(coarse), max(4, round(turn))
    amplitude = over_gaps(running_amplitude(coarse, lap), lead.lost, step, lap)
    floor = max(6.0 * lead.noise / np.sqrt(step * turn), 0.05 * float(amplitude.max()))
    bursts: list[Burst] = []
    position = 0
    while position < n:
        above = np.flatnonzero(amplitude[position:] > floor)
        if len(above) == 0:
            break
        first = position + int(above[0])
        peak = first + int(np.argmax(amplitude[first : first + 4 * lap]))
        later = amplitude[min(peak + round(1.6 * lap), n - 1)]
        if later < 0.1 * amplitude[peak] and peak + 1.6 * lap < n:
            position = max(peak + lap, first + 1)
            continue
        half = np.flatnonzero(amplitude[first : peak + 1] < 0.5 * amplitude[peak])
        start = first + int(half[-1]) if len(half) else first
        size, before = float(amplitude[peak]), first
        mirrored = bool(bursts) and _is_mirrored(amplitude, position, min(size, bursts[-1].amplitude))
        while mirrored and peak > before:  # after the node of a beat it may grow for long
            before, peak = peak, peak + int(np.argmax(amplitude[peak : peak + lap]))
        stop, size = _where_it_ends(amplitude, peak, floor), float(amplitude[peak])
        bursts.append(Burst(start * step, min(stop * step, len(lead.values)), size, mirrored))
        position = max(stop, peak + 1)
    return bursts


def _is_mirrored(amplitude: Array, node: int, size: float) -> bool:
    """Check whether an amplitude fell to a node in about the time in which it rises to a `size` again; a push is steeper."""
    above = amplitude > np.sqrt(size * amplitude[node])
    before, after = np.flatnonzero(above[:node]), np.flatnonzero(above[node:])
    if not len(before) or not len(after):
        return False
    fall, rise = node - before[-1], after[0]
    return bool(max(fall, rise) < _MIRRORED * min(fall, rise))


def _where_it_ends(amplitude: Array, peak: int, floor: float) -> int:
    """The first place after the peak that is below the floor, or from which the amplitude rises steeply again."""
    n = len(amplitude)
    lowest = np.minimum.accumulate(amplitude[peak:])
    rises = np.flatnonzero((amplitude[peak:] > 1.8 * lowest) & (amplitude[peak:] > floor))
    rise = int(rises[0]) if len(rises) else n - peak
    below = np.flatnonzero(amplitude[peak:] < 0.4 * floor)
    end = int(below[0]) if len(below) else n - peak
    if rise < end:
        return peak + int(np.argmin(amplitude[peak : peak + rise + 1]))
    return peak + end


def coarse_means(channel: Channel, period: float) -> tuple[Array, int, float]:
    """Return block means, the samples of a block, and the blocks of a period.

    An acceleration is freed of blows shorter than a twelfth of a period by a running median.
    """
    step = max(1, round(period / POINTS_PER_PERIOD))
    means, turn = block_means(channel.values, step), period / step
    if channel.derivative >= 2:
        means = running_median(means, 2 * max(1, round(turn / 12.0)) + 1)
    return means, step, turn


def unfree_runs(values: Array, turn: float, noise: float) -> tuple[Array, list[tuple[int, int]], float]:
    """Find the runs of a force that is not the oscillator's own; the last `turn` of the values is free.

    Returns the force, the runs and the amplitude of the free turn.
    """
    size = float(np.std(values[-round(turn) :])) * np.sqrt(2.0)
    least = UNFREE_SHARE * size
    force, uncertainty = unfree(values, turn, noise, 0.25 * least)
    return force, runs_of(np.abs(force) > max(least, 4.0 * uncertainty)), size


def end_of(channel: Channel, period: float, burst: Burst) -> int:
    """Return one past the last sample of a burst's free motion."""
    ends = _end_of_motion(channel, period, burst), _taken_again(channel, period, burst)
    return min(*ends, first_gap(channel.lost, burst.start, period))


def _taken_again(channel: Channel, period: float, burst: Burst) -> int:
    """Find where a hand takes the mass again near the end of a burst; the record's end where none does.

    It is the first force that is not the oscillator's own, if such a force lasts, and none acts in the cycles before: an
    end stop acts in each.
    """
    coarse, step, turn = coarse_means(channel, period)
    last = min(int(burst.stop / step + turn) + 1, len(coarse))
    first = max(int(burst.start / step + 1.5 * turn), last - round(LAST_CYCLES * turn))
    if last - first < 3.0 * turn:
        return len(channel.values)
    _, backwards, _ = unfree_runs(coarse[first:last][::-1], turn, channel.noise / np.sqrt(step))
    runs = [(last - stop, last - begin) for begin, stop in reversed(backwards)]
    lasts = any(stop - begin > TAKEN_FOR * turn for begin, stop in runs)
    return runs[0][0] * step if lasts and runs[0][0] > first + 2.0 * turn else len(channel.values)


def _end_of_motion(channel: Channel, period: float, burst: Burst) -> int:
    """One past the last sample that differs from where the mass comes to rest, or where the burst stops."""
    n = len(channel.values)
    stop = min(burst.stop, n)
    tail = channel.values[max(stop - round(0.5 * period), 0) : min(stop + round(period), n)]
    if stop >= n or len(tail) < 4:
        return n
    level = float(np.median(tail))
    tolerance = max(5.0 * channel.noise, 0.003 * burst.amplitude)
    first = max(burst.start, 0)
    moving = np.flatnonzero(np.abs(channel.values[first:stop] - level) > tolerance)
    return first + int(moving[-1]) + 1 if len(moving) else stop
