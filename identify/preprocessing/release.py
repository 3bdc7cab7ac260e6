"""The release: where in a record the motion becomes free."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from identify.arrays import Array, Mask
from identify.errors import NotIdentifiable
from identify.free_decay import CHANNELS, FreeDecay
from identify.preprocessing.bursts import (
    Burst,
    Channel,
    coarse_means,
    end_of,
    find_bursts,
    unfree_runs,
)
from identify.preprocessing.lost_readings import single_spikes
from identify.preprocessing.noise import floor_above_motion
from identify.preprocessing.onset import Onset, locate
from identify.preprocessing.sampling import LONG_GAP, too_coarse
from identify.signal.fractional_delay import bridge
from identify.signal.oscillation import dominant_frequency, running_amplitude
from identify.signal.running import running_maximum, running_minimum, runs_of
from identify.signal.smoothing import without_line

ReleaseKind = Literal["displaced", "impulse", "in_motion"]

HAND_S = 0.030
"""A hand has surely let go this long after the release: it takes 20 ms at most, and channels differ by 3 ms."""

LEAD_S = 0.015
"""The rest ends this long before the release: half a slow hand, and an early channel."""

AT_REST, NOISY = 0.02, 1.5
"""What comes before a rise is at rest up to this share of its amplitude, or up to so many times the noise."""


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
    bursts = find_bursts(lead, period)
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
    rate: float, channels: list[Channel], period: float, bursts: list[Burst]
) -> list[Burst]:
    """Join bursts that are beats of one motion: one rises again as it fell, though nothing held or struck it.

    Two modes, or a damper that gives back what it took, do so.
    """
    joined = bursts[:1]
    for burst in bursts[1:]:
        before = joined[-1]
        lost = channels[0].lost[before.stop : max(burst.start, before.stop + 1)]
        again = burst.mirrored and not np.any(lost)
        if again and all(_onset(rate, c, period, burst, before.stop) is None for c in channels):
            joined[-1] = before._replace(stop=burst.stop)
        else:
            joined.append(burst)
    return joined


def _channels(decay: FreeDecay) -> list[Channel]:
    channels = []
    for name, values in decay.channels.items():
        known = np.isfinite(values) if decay.valid is None else np.isfinite(values) & decay.valid
        whole = bridge(values, known)
        clean = bridge(whole, ~single_spikes(whole, floor_above_motion(whole, known).std))
        channels.append(Channel(clean, CHANNELS.index(name), floor_above_motion(clean, known).std, ~known))
    return channels


def _no_ringing(lead: Channel, frequency: float, period: float) -> str:
    """Say why a record has no release: nothing stands above the noise, or the motion ends at once."""
    amplitude = running_amplitude(lead.values, max(4, round(period)))
    if amplitude.max() > 6.0 * lead.noise / np.sqrt(period):
        return (
            f"The motion at the strongest frequency, {frequency:.3g} Hz, ends within two cycles: it is a push, it is too "
            "strongly damped, or its frequency changes as it decays. Leave a push out, or release from a smaller amplitude."
        )
    return "Nothing in the record oscillates above its noise: check the channel, or release from a larger amplitude."


def _release(rate: float, channels: list[Channel], period: float, burst: Burst, earliest: int) -> Release:
    n = len(channels[0].values)
    found = _onsets(rate, channels, period, burst, earliest)
    gap = _gap_before(channels[0], period, burst, earliest)
    if gap is not None and all(onset.place >= gap[0] for _, onset in found):
        # nobody saw what happened there
        earliest = gap[1]
        burst = burst._replace(start=max(burst.start, earliest))
        found = _onsets(rate, channels, period, burst, earliest)
    end = end_of(channels[0], period, burst)
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


def _gap_before(lead: Channel, period: float, burst: Burst, earliest: int) -> tuple[int, int] | None:
    """Return the last gap of half a period or more that begins before or in the first cycle of a burst; None without one."""
    gaps = (gap for gap in runs_of(lead.lost) if np.ptp(gap) >= LONG_GAP * period)
    return max((gap for gap in gaps if gap[0] < burst.start + period and gap[1] > earliest), default=None)


def _onsets(
    rate: float, channels: list[Channel], period: float, burst: Burst, earliest: int
) -> list[tuple[Channel, Onset]]:
    """List the channels that show where the hand's force ends, with that place."""
    onsets = [(channel, _onset(rate, channel, period, burst, earliest)) for channel in channels]
    return [(channel, onset) for channel, onset in onsets if onset is not None]


def _onset(rate: float, channel: Channel, period: float, burst: Burst, earliest: int) -> Onset | None:
    """Where the hand's force ends, coarsely, then by the change-point fit; None when nothing held the mass."""
    coarse, step, turn = coarse_means(channel, period)
    first = max(int(burst.start / step - 1.2 * turn), earliest // step, 0)
    last = min(int(burst.start / step + 2.0 * turn) + 1, len(coarse))
    if last - first < 8:
        return None
    force, runs, size = unfree_runs(coarse[first:last], turn, channel.noise / np.sqrt(step))
    runs = [run for run in runs if run[1] < last - first - 2]
    if not runs or size <= 0.0:
        return None
    begin, stop = max(runs, key=lambda run: float(np.sum(force[run[0] : run[1]] ** 2)))
    around = (first + stop - 0.5) * step
    push = min(0.5 * HAND_S * rate, 0.1 * period) + 1.0
    onset = locate(channel.values, period, channel.derivative, around, max(0.15 * period, 2.0), push)
    if onset is not None and onset.misfit < 0.5 * onset.misfit_without:
        return onset
    # the coarse place may be late: a hold is looked at until well before it, a short one for four points
    since, well, just = (max(first + stop - round(share * turn), 0) for share in (1.0, 0.2, 0.1))
    before = coarse[since : max(well, min(since + 4, just))]
    if (
        stop - begin < 0.1 * turn
        or len(before) < 4
        or np.std(without_line(before)) > 0.3 * np.std(without_line(coarse[last - round(turn) : last]))
    ):
        return None
    level = float(coarse[first + stop - 1] - coarse[first + stop : last].mean())
    return Onset(around, 0.05 * period, level, 0.0, 0.0, 0.0)


def _rest(
    found: list[tuple[Channel, Onset]],
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
