"""Faults of a sensor during the record: where each channel is flagged, what that means, and what to do about it."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel, ConfigDict

from daq.cycle_gains import Step, cycle_length, gain_steps
from daq.decode import Assembly
from daq.reading_flags import Flag, Flagged, flag_readings
from daq.recording import MOTIONS, Array, Channel, Mask, Recording, Suspicion, runs
from daq.smooth_course import last_moving
from firmware_protocol import NO_CHANNEL, EventKind

SATURATED_LIMIT = 3
BLOW_S = 0.05
FEW = 0.02
"""Share of a motion's readings that may be spikes or repeated without spoiling the record."""
FEWEST, LEAST = 8, 0.005
"""Repeated readings, and their share, below which a motion's own kinks may have made them."""
LARGEST = 1e100
LONGEST = 1 << 18
"""Readings from the release on that are looked at."""
MOST_RUNS = 1000

WORDS = {
    Flag.STUCK: ("is stuck while the mass moves,", "check the sensor of {} and its cable"),
    Flag.REPEATED: (
        "repeats the reading before it",
        "check how the converter of {} is read, and how often; write a row only for a new reading",
    ),
    Flag.SATURATED: ("is cut off flat", "a smaller release, or a wider range of {}"),
    Flag.WRAPPED: (
        "wraps round from one end of its range to the other",
        "a smaller release, or a wider range of {}; of a file, `wraps` in its recipe, as wraps = 360",
    ),
    Flag.SPIKE: ("leaps away from its neighbours", "look for a loose contact or interference on {}"),
}
STEP_ADVICE = "check the amplifier, the range and the mounting of the sensor of {}"


class FlaggedRun(BaseModel):
    """Samples `first` to `first + count - 1` of the channel of that name, with one flag."""

    model_config = ConfigDict(frozen=True)

    channel: str
    flag: Flag
    first: int
    count: int


@dataclass(frozen=True)
class SensorFaults:
    """What the sensors did during the record: `suspicions` in words, `runs` of flagged samples by channel."""

    suspicions: tuple[Suspicion, ...]
    runs: tuple[FlaggedRun, ...]


@np.errstate(all="ignore")  # numbers of a board may be anything
def sensor_faults(recording: Recording, assembly: Assembly | None = None) -> SensorFaults:
    """Look at every channel reading by reading and cycle by cycle; `assembly` adds what the board itself reported."""
    looked, period, first = _looked(recording)
    driven = any(channel.quantity == "force" for channel in recording.channels)
    suspicions: list[Suspicion] = []
    flagged: list[FlaggedRun] = []
    for number, channel in enumerate(recording.channels):
        masks = {flag: np.zeros(len(recording.valid), dtype=np.bool_) for flag in Flag}
        moving, steps = 0, tuple[Step, ...]()
        if number in looked:
            course = looked[number]
            moving = int(course.moving.sum())
            steps = () if driven else gain_steps(course.filled, period, course.moving)
            for flag, mask in course.masks.items():
                masks[flag][first : first + len(mask)] = mask
        ends = _ends(recording, number, assembly)
        suspicions += _of_range(recording, channel, *ends)
        for flag in WORDS:
            masks[flag] &= ~(ends[0] | ends[1])
        for step in steps:
            at = first + step.index
            masks[Flag.SPIKE][max(at - round(period), 0) : at + round(period)] = False
            masks[Flag.SIGN if step.reverses else Flag.GAIN][at:] ^= True
            suspicions.append(_of_step(recording, number, step, at))
        suspicions += [
            s for flag in WORDS for s in _of_readings(recording, number, flag, masks[flag], moving)
        ]
        masks[Flag.SATURATED] |= ends[0] | ends[1]
        flagged += [run for flag, mask in masks.items() for run in _runs(channel, flag, mask)]
    return SensorFaults(tuple(suspicions), tuple(flagged))


def _looked(recording: Recording) -> tuple[dict[int, Flagged], float, int]:
    """Return the flags of the channels that oscillate, by number; their period, 0 for none; and the first reading."""
    first = recording.trigger or 0
    part = slice(first, first + LONGEST)
    moved: dict[int, tuple[Array, Mask]] = {}
    for number, (channel, samples) in enumerate(
        zip(recording.channels, recording.samples[:, part], strict=True)
    ):
        there = recording.valid[part] & np.isfinite(samples)
        enough = there.sum() > 0.5 * len(there) and 0.0 < np.ptp(samples[there]) < LARGEST
        if channel.quantity in MOTIONS and enough:
            filled = np.interp(np.arange(len(samples)), np.flatnonzero(there), samples[there])
            moved[number] = filled, there
    period = cycle_length(tuple(filled for filled, _ in moved.values())) if moved else None
    if period is None:
        return {}, 0.0, first
    until = {number: last_moving(filled, period) for number, (filled, _) in moved.items()}
    released = None if recording.trigger is None else round(BLOW_S * recording.rate)
    looked = {}
    for number, (filled, there) in moved.items():
        others = max((last for other, last in until.items() if other != number), default=0)
        looked[number] = flag_readings(filled, there, period, others, released)
    return looked, period, first


def _of_step(recording: Recording, number: int, step: Step, at: int) -> Suspicion:
    name = recording.channels[number].name
    when = f"at about {at / recording.rate:.2f} s"
    advice = STEP_ADVICE.format(name)
    if step.reverses:
        return Suspicion(True, f"{name} changes its sign {when}, while the oscillation goes on", advice)
    return Suspicion(True, f"the size of {name} changes by a factor of {step.factor:.2f} {when}", advice)


def _of_readings(
    recording: Recording, number: int, flag: Flag, mask: Mask, moving: int
) -> Iterator[Suspicion]:
    """Say of one flag of a channel where it is; few spikes and few repeated readings leave the record usable."""
    count = int(mask.sum())
    if not count or (flag is Flag.REPEATED and count < max(FEWEST, LEAST * moving)):
        mask[:] = False
        return
    name, rate = recording.channels[number].name, recording.rate
    what, advice = WORDS[flag]
    spans = runs(mask)
    first = spans[0][0] / rate
    if flag is Flag.STUCK:
        begin, stop = max(spans, key=lambda span: span[1] - span[0])
        more = f" and {len(spans) - 1} times more" if len(spans) > 1 else ""
        reason = f"{name} {what} for {(stop - begin) / rate:.3g} s from {begin / rate:.3f} s on{more}"
    else:
        reason = f"{name} {what} in {count} sample{'s' if count > 1 else ''}, first at {first:.3f} s"
    few = flag in (Flag.SPIKE, Flag.REPEATED) and count <= FEW * moving
    yield Suspicion(not few, reason, advice.format(name))


def _ends(recording: Recording, number: int, assembly: Assembly | None) -> tuple[Mask, Mask, bool]:
    """Return which readings are at an end of the stated range, outside the blow and in it; and if the board said so."""
    blow = np.zeros(len(recording.valid), dtype=np.bool_)
    if recording.trigger is not None:
        after = recording.trigger + round(BLOW_S * recording.rate)
        blow[max(recording.trigger - 2, 0) : after] = True
    seen = _at_end(recording.channels[number], recording.samples[number])
    reported = np.zeros_like(blow)
    events, start = (assembly.events, assembly.start) if assembly is not None else ([], 0)
    for event in events:
        if event.kind == EventKind.SATURATION and event.channel in (number, NO_CHANNEL):
            reported[max(event.index - start, 0) : max(event.index - start + event.count, 0)] = True
    ends = seen | reported
    return ends & ~blow, ends & blow, bool(reported[~blow].any())


def _of_range(
    recording: Recording, channel: Channel, outside: Mask, inside: Mask, reported: bool
) -> Iterator[Suspicion]:
    """A blow may saturate, what follows it may not."""
    count, in_blow = int(outside.sum()), int(inside.sum())
    wider = f"a wider range of {channel.name}"
    if count >= SATURATED_LIMIT or reported:
        first = int(np.argmax(outside)) / recording.rate
        reason = f"{channel.name} is at the end of its range in {count} samples, first at {first:.3f} s"
        yield Suspicion(True, reason, f"a smaller release, or {wider}")
    elif in_blow:
        reason = f"{channel.name} is at the end of its range in {in_blow} samples at the release"
        yield Suspicion(False, reason, f"a softer blow, or {wider}")


def _at_end(channel: Channel, samples: Array) -> Mask:
    """Mark samples within one code of an end of the range that stay there for two samples or more."""
    step = channel.resolution or 0.0
    at_end = np.zeros(len(samples), dtype=np.bool_)
    if channel.high is not None:
        at_end |= samples >= channel.high - 1.01 * step
    if channel.low is not None:
        at_end |= samples <= channel.low + 1.01 * step
    stays = np.zeros_like(at_end)
    stays[1:] |= at_end[1:] & at_end[:-1]
    stays[:-1] |= at_end[1:] & at_end[:-1]
    return stays


def _runs(channel: Channel, flag: Flag, mask: Mask) -> Iterator[FlaggedRun]:
    """Return the runs of a mask; beyond a thousand the shortest pauses between them are flagged as well."""
    if not mask.any():
        return
    found = np.array(runs(mask))
    pauses = found[1:, 0] - found[:-1, 1]
    kept = np.sort(np.argsort(pauses)[::-1][: MOST_RUNS - 1])
    for first, stop in zip(found[np.r_[0, kept + 1], 0], found[np.r_[kept, -1], 1], strict=True):
        yield FlaggedRun(channel=channel.name, flag=flag, first=first, count=stop - first)
