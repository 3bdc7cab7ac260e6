"""The release: where in a record the motion becomes free."""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from identify.arrays import Array, Mask
from identify.errors import NotIdentifiable
from identify.free_decay import CHANNELS, FreeDecay
from identify.preprocessing.noise import floor_above_motion
from identify.preprocessing.onset import Onset, locate
from identify.preprocessing.sampling import block_means, first_gap, over_gaps, too_coarse
from identify.signal.fractional_delay import bridge
from identify.signal.oscillation import dominant_frequency, running_amplitude, unfree
from identify.signal.running import running_maximum, running_median, running_minimum, runs_of
from identify.signal.smoothing import without_line

ReleaseKind = Literal["displaced", "impulse", "in_motion"]

HAND_S = 0.030
"""A hand has surely let go this long after the release: it takes 20 ms at most, and channels differ by 3 ms."""

LEAD_S = 0.015
"""The rest ends this long before the release: half a slow hand, and an early channel."""

UNFREE_SHARE = 0.35
"""A force beyond the springs' of this share of theirs is a hand: friction and damping are far smaller."""

LAST_CYCLES, TAKEN_FOR = 4.5, 0.25
"""Cycles before the end of a burst in which a hand may take the mass again, and how long it does, in cycles, at least."""

BEAT_SHARE = 0.9
"""A motion that rises again to more than this share of its amplitude was released again: damping takes some of a beat."""

AT_REST, NOISY = 0.02, 1.5
"""What comes before a rise is at rest up to this share of its amplitude, or up to so many times the noise."""

POINTS_PER_PERIOD = 48
"""The coarse search looks at block means of about this many samples a period."""


@dataclass(frozen=True)
class Release:
    """The release: the time from which the motion is free.

    `time_s` (sub-sample, from the first sample) and its standard error `std_s`; `index` is the first
    sample of free motion; `settle` is the first sample at which the hand has surely let go (use it as the start of
    fits); `end` is one past the last sample of motion (after it the mass is stuck, or the record ends).
    `kind` is "displaced" (held away from zero, then let go), "impulse" (an initial velocity) or
    "in_motion" (the record begins in mid-decay, or rises without a hand that is seen). `rest` is the half-open range of
    samples at rest before it, (0, 0) when there is none.
    """

    time_s: float
    std_s: float
    index: int
    settle: int
    end: int
    kind: ReleaseKind
    rest: tuple[int, int]


class _Channel(NamedTuple):
    values: Array
    derivative: int
    noise: float
    lost: Mask


class _Burst(NamedTuple):
    """A sustained oscillation, in samples: where it may have begun and where it had died or the next one begins."""

    start: int
    stop: int
    amplitude: float


def release_of(decay: FreeDecay) -> Release:
    """Find the release with the largest motion in a record; the whole record where a force drives it."""
    if decay.driven:
        return Release(0.0, 0.0, 0, 0, len(decay), "in_motion", (0, 0))
    return max(_search(decay), key=lambda item: item[0])[1]


def find_releases(decay: FreeDecay) -> tuple[Release, ...]:
    """Find every release in a record, in order.

    A release is the start of an oscillation that lasts: a bump or the pull that displaces the mass does not ring. Times
    are on the acceleration's clock where there is one. Raises NotIdentifiable when nothing in the record oscillates freely.
    """
    return tuple(release for _, release in _search(decay))


def _search(decay: FreeDecay) -> list[tuple[float, Release]]:
    rate, channels = decay.rate, _channels(decay)
    lead = channels[0]
    frequency = dominant_frequency(lead.values, rate, lead.derivative)
    if frequency <= 0.0 or len(lead.values) * frequency / rate < 2.5:
        raise NotIdentifiable(
            "No free oscillation was found in the record: it needs at least three cycles after a release."
        )
    period = rate / frequency
    bursts = _bursts(lead, period)
    if not bursts:
        raise NotIdentifiable(
            too_coarse(lead.values, rate, lead.derivative) or _no_ringing(lead, frequency, period)
        )
    bursts = _with_beats_whole(rate, channels, period, bursts)
    earliest = (0, *(burst.stop for burst in bursts))
    return [
        (burst.amplitude, _release(rate, channels, period, burst, free))
        for burst, free in zip(bursts, earliest, strict=False)
    ]


def _with_beats_whole(
    rate: float, channels: list[_Channel], period: float, bursts: list[_Burst]
) -> list[_Burst]:
    """Join bursts that are beats of one motion: one rises again, to less than before, though nothing held or struck it.

    Two modes, or a damper that gives back what it took, do so; a free motion never rises above what it was.
    """
    joined = bursts[:1]
    for burst in bursts[1:]:
        before = joined[-1]
        lost = channels[0].lost[before.stop : max(burst.start, before.stop + 1)]
        again = burst.amplitude < BEAT_SHARE * before.amplitude and not np.any(lost)
        if again and all(_onset(rate, c, period, burst, before.stop) is None for c in channels):
            joined[-1] = before._replace(stop=burst.stop)
        else:
            joined.append(burst)
    return joined


def _channels(decay: FreeDecay) -> list[_Channel]:
    channels = []
    for name, values in decay.channels.items():
        known = np.isfinite(values) if decay.valid is None else np.isfinite(values) & decay.valid
        clean = _without_spikes(bridge(values, known))
        channels.append(_Channel(clean, CHANNELS.index(name), floor_above_motion(clean, known).std, ~known))
    return channels


def _without_spikes(values: Array) -> Array:
    """Replace single samples far off the cubic through their neighbours.

    A spike of height s puts its neighbours off by 2 s/3, a jump puts the samples on either side off equally: it stays.
    """
    if len(values) < 16:
        return values
    padded = np.pad(values, 2, mode="edge")
    cubic = np.correlate(padded, np.array([-1.0, 4.0, 0.0, 4.0, -1.0]) / 6.0, "valid")
    off = np.abs(values - cubic)
    beside = np.maximum(np.pad(off[1:], (0, 1)), np.pad(off[:-1], (1, 0)))
    spike = (off > 1.25 * beside) & (off > 12.0 * float(np.median(off)) + 0.03 * float(np.ptp(values)))
    return np.where(spike, cubic, values)


def _bursts(lead: _Channel, period: float) -> list[_Burst]:
    """Find sustained oscillations by their running amplitude: a steep rise, then more than a pulse."""
    step = max(1, round(period / POINTS_PER_PERIOD))
    coarse = _coarse(lead, step, period)
    turn = period / step
    n, lap = len(coarse), max(4, round(turn))
    amplitude = over_gaps(running_amplitude(coarse, lap), lead.lost, step, lap)
    floor = max(6.0 * lead.noise / np.sqrt(step * turn), 0.05 * float(amplitude.max()))
    bursts: list[_Burst] = []
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
        stop = _where_it_ends(amplitude, peak, floor)
        bursts.append(_Burst(start * step, min(stop * step, len(lead.values)), float(amplitude[peak])))
        position = max(stop, peak + 1)
    return bursts


def _no_ringing(lead: _Channel, frequency: float, period: float) -> str:
    """Say why a record has no release: nothing stands above the noise, or the motion ends at once."""
    amplitude = running_amplitude(lead.values, max(4, round(period)))
    if amplitude.max() > 6.0 * lead.noise / np.sqrt(period):
        return (
            f"The motion at the strongest frequency, {frequency:.3g} Hz, ends within two cycles: it is a push, it is too "
            "strongly damped, or its frequency changes as it falls. Leave a push out, or release from a smaller amplitude."
        )
    return (
        "Nothing in the record oscillates above its noise: check the channel, or release from further away."
    )


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


def _coarse(channel: _Channel, step: int, period: float) -> Array:
    """Block means; an acceleration is freed of blows shorter than a twelfth of a period by a running median."""
    means = block_means(channel.values, step)
    if channel.derivative < 2:
        return means
    width = 2 * max(1, round(period / step / 12.0)) + 1
    return running_median(means, width)


def _release(rate: float, channels: list[_Channel], period: float, burst: _Burst, earliest: int) -> Release:
    onsets = [(channel, _onset(rate, channel, period, burst, earliest)) for channel in channels]
    found = [(channel, onset) for channel, onset in onsets if onset is not None]
    n = len(channels[0].values)
    lead = channels[0]
    end = min(
        _end_of_motion(lead, period, burst),
        _taken_again(lead, period, burst),
        first_gap(lead.lost, burst.start, period),
    )
    if not found:  # free from the beginning, or once it has risen from rest
        before = channels[0].values[earliest : max(burst.start - round(period), earliest)]
        rises = len(before) > 3 and np.std(before) < max(AT_REST * burst.amplitude, NOISY * channels[0].noise)
        start = burst.start + round(period) if rises else earliest
        return Release(start / rate, 0.0, start, start, max(end, start), "in_motion", (0, 0))
    onset = found[-1][1]  # the highest derivative's: it shows most sharply when the force changed
    time_s = onset.place / rate
    index = int(np.ceil(onset.place - 1e-9))
    # a hand takes 20 ms at most at any frequency, so 30 ms; 5 % of a period where that is longer, one period at most
    hand = min(max(HAND_S * rate, 0.05 * period), period)
    letting_go = hand + (2.0 * onset.std if onset.std > 1.0 else 0.0)
    settle = min(index + max(1, int(np.ceil(letting_go))), n - 1)
    rest = _rest(found, rate, period, onset.place, earliest)
    kind: ReleaseKind = "displaced" if abs(found[0][1].displaced) >= abs(found[0][1].impulse) else "impulse"
    return Release(time_s, onset.std / rate, index, settle, max(end, settle), kind, rest)


def _onset(rate: float, channel: _Channel, period: float, burst: _Burst, earliest: int) -> Onset | None:
    """Where the hand's force ends, coarsely, then by the change-point fit; None when nothing held the mass."""
    step = max(1, round(period / POINTS_PER_PERIOD))
    coarse = _coarse(channel, step, period)
    turn = period / step
    first = max(int(burst.start / step - 1.2 * turn), earliest // step, 0)
    last = min(int(burst.start / step + 2.0 * turn) + 1, len(coarse))
    if last - first < 8:
        return None
    noise = channel.noise / np.sqrt(step)
    size = float(np.std(coarse[last - round(turn) : last])) * np.sqrt(2.0)
    least = UNFREE_SHARE * size
    force, uncertainty = unfree(coarse[first:last], turn, noise, 0.25 * least)
    runs = runs_of(np.abs(force) > max(least, 4.0 * uncertainty))
    runs = [run for run in runs if run[1] < last - first - 2]
    if not runs or size <= 0.0:
        return None
    begin, stop = max(runs, key=lambda run: float(np.sum(force[run[0] : run[1]] ** 2)))
    around = (first + stop - 0.5) * step
    push = min(0.5 * HAND_S * rate, 0.1 * period) + 1.0
    onset = locate(channel.values, period, channel.derivative, around, max(0.15 * period, 2.0), push)
    if onset is not None and onset.misfit < 0.5 * onset.misfit_without:
        return onset
    before = coarse[max(first + stop - round(turn), 0) : first + stop - round(0.1 * turn)]
    if (
        stop - begin < 0.1 * turn
        or len(before) < 4
        or np.std(without_line(before)) > 0.6 * np.std(without_line(coarse[last - round(turn) : last]))
    ):
        return None
    level = float(coarse[first + stop - 1] - coarse[first + stop : last].mean())
    return Onset(around, 0.05 * period, level, 0.0, 0.0, 0.0)


def _rest(
    found: list[tuple[_Channel, Onset]],
    rate: float,
    period: float,
    onset: float,
    earliest: int,
) -> tuple[int, int]:
    """The last quiet stretch before the onset."""
    stop = int(np.floor(onset - max(2.0, min(LEAD_S * rate, 0.25 * period))))
    if stop - earliest < 4:
        return (0, 0)
    quiet = np.ones(stop - earliest, dtype=bool)
    for channel, begun in found:
        size = max(abs(begun.displaced), abs(begun.impulse))
        window = max(3, min(round(period / 4.0), (stop - earliest) // 3))
        quiet &= _still(channel.values[earliest:stop], window, max(8.0 * channel.noise, 0.02 * size))
    runs = runs_of(quiet)
    if not runs:
        return (0, 0)
    first, last = runs[-1]
    return (earliest + first, earliest + last) if last - first >= 4 else (0, 0)


def _still(values: Array, window: int, tolerance: float) -> Mask:
    """Where the channel stays within the tolerance over a window of `window` samples that holds the sample."""
    calm = running_maximum(values, window) - running_minimum(values, window) <= tolerance
    return running_maximum(calm[::-1], window)[::-1]


def _taken_again(channel: _Channel, period: float, burst: _Burst) -> int:
    """Find where a hand takes the mass again near the end of a burst; the burst's end where none does.

    It is the first force that is not the oscillator's own, if such a force lasts, and none acts in the cycles before: an
    end stop acts in each.
    """
    step = max(1, round(period / POINTS_PER_PERIOD))
    coarse, turn = _coarse(channel, step, period), period / step
    last = min(int(burst.stop / step + turn) + 1, len(coarse))
    first = max(int(burst.start / step + 1.5 * turn), last - round(LAST_CYCLES * turn))
    if last - first < 3.0 * turn:
        return len(channel.values)
    backwards = coarse[first:last][::-1]
    size = float(np.std(backwards[-round(turn) :])) * np.sqrt(2.0)
    least = UNFREE_SHARE * size
    force, uncertainty = unfree(backwards, turn, channel.noise / np.sqrt(step), 0.25 * least)
    runs = runs_of(np.abs(force[::-1]) > max(least, 4.0 * uncertainty))
    lasts = any(stop - begin > TAKEN_FOR * turn for begin, stop in runs)
    return (first + int(runs[0][0])) * step if lasts and runs[0][0] > 2.0 * turn else len(channel.values)


def _end_of_motion(channel: _Channel, period: float, burst: _Burst) -> int:
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
