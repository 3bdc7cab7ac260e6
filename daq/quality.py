"""The verdict on a recording: OK, USABLE WITH GAPS or REJECT, with the reasons in words.

It judges what was recorded, not what it means: losses, a dead channel, too little motion, faults of the sensors, a
start in mid-motion, noise, clocks, END against the samples, channels that contradict each other.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from enum import StrEnum

import numpy as np
from pydantic import AliasChoices, BaseModel, ConfigDict, Field

from daq.clock_check import checked_rate
from daq.decode import IMPORT, Assembly
from daq.importing.options import QUANTITIES
from daq.importing.units import SI_ANGULAR, SI_LINEAR
from daq.recording import Array, Channel, Gap, Recording, Suspicion
from daq.sensor_faults import SensorFaults, sensor_faults
from firmware_protocol import End, EventKind

LOST_LIMIT = 0.02
LONGEST_GAP_S = 0.25
MOTION_TO_NOISE = 20.0
EARLY_SHARE = 0.1
EARLY_SWING = 0.25
SCALE_LIMIT = 1.75
SHORTEST = 32


class Grade(StrEnum):
    """How good a recording is."""

    OK = "OK"
    USABLE = "USABLE WITH GAPS"
    REJECT = "REJECT"


class Verdict(BaseModel):
    """A grade and its reasons, worst first; `advice` says what to do before taking it again.

    `remarks` tell what was checked and found good. In files and in JSON the grade stands under `word`.
    """

    model_config = ConfigDict(frozen=True, serialize_by_alias=True)

    grade: Grade = Field(validation_alias=AliasChoices("word", "grade"), serialization_alias="word")
    reasons: tuple[str, ...] = ()
    advice: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def words(self) -> str:
        """The grade and its reasons in one line."""
        return "; ".join([self.grade.value, *self.reasons])


@np.errstate(over="ignore", invalid="ignore")  # numbers of a board may be anything
def judge(
    recording: Recording,
    assembly: Assembly | None = None,
    planned: int | None = None,
    noise: Mapping[str, float] | None = None,
    check_clock: bool = True,
    sensors: SensorFaults | None = None,
) -> Verdict:
    """Return the verdict on a recording.

    `assembly` adds what the board and the wire reported, `planned` the number of samples wanted, `noise` the
    standard deviation of each channel at rest by its name (channel's unit), `sensors` what `sensor_faults` found where
    that is known.
    """
    found = [*_losses(recording, planned)]
    for channel, samples in zip(recording.channels, recording.samples, strict=True):
        found += _one_channel(channel, samples[recording.valid], (noise or {}).get(channel.name))
    found += (sensors or sensor_faults(recording, assembly)).suspicions
    found += (*_start(recording), *wiring(recording))
    remarks: list[str] = []
    if assembly is not None:
        found += _board_reports(assembly)
        if assembly.origin != IMPORT:
            found += _units(recording)
            found += integrity(assembly, remarks)
            found += checked_rate(assembly, check_clock).suspicions
    found.sort(key=lambda suspicion: not suspicion.certain)
    grade = (Grade.REJECT if found[0].certain else Grade.USABLE) if found else Grade.OK
    advice = dict.fromkeys(suspicion.advice for suspicion in found if suspicion.advice)
    reasons = tuple(suspicion.reason for suspicion in found)
    return Verdict(grade=grade, reasons=reasons, advice=tuple(advice), remarks=tuple(remarks))


def summary(gaps: Iterable[Gap]) -> str:
    """Return lost samples by reason: `16 on the wire, 32 by overrun of the board`."""
    words = {
        "wire": "on the wire",
        "overrun": "by overrun of the board",
        "reboot": "by a reboot of the board",
    }
    counts: Counter[str] = Counter()
    for gap in gaps:
        counts[gap.reason] += gap.count
    return ", ".join(f"{n} {words.get(reason, f'({reason})')}" for reason, n in counts.items())


def _losses(recording: Recording, planned: int | None) -> Iterator[Suspicion]:
    n = len(recording.valid)
    lost = int(n - recording.valid.sum())
    if planned is not None and n < planned:
        reason = f"ends {(planned - n) / recording.rate:.2f} s early, after {n} of {planned} samples"
        yield Suspicion(n / planned < 0.5, reason, "check cable and board")
    if not lost:
        return
    longest = max((gap.count for gap in recording.gaps), default=lost) / recording.rate
    reason = f"{lost} of {n} samples lost: {summary(recording.gaps)}; the longest gap {longest * 1e3:.0f} ms"
    if recording.trigger is not None and recording.valid[recording.trigger :].all():
        reason += ", all before the release"
    many = lost > LOST_LIMIT * n or longest > LONGEST_GAP_S
    yield Suspicion(many, reason, "a shorter cable, a slower rate, or a faster port")


def _one_channel(channel: Channel, samples: Array, noise: float | None) -> Iterator[Suspicion]:
    if not len(samples):
        return
    span = float(np.ptp(samples))
    if span <= (channel.resolution or 0.0):
        reason = f"{channel.name} does not move: dead, or not connected"
        yield Suspicion(True, reason, f"check the sensor of {channel.name}")
    elif noise is not None and span < MOTION_TO_NOISE * noise:
        reason = f"{channel.name} moves by only {span / noise:.0f} times its noise"
        yield Suspicion(True, reason, "a larger release")


def _start(recording: Recording) -> Iterator[Suspicion]:
    """A capture that begins in mid-motion has missed its release; one that a touch has set off comes too early."""
    trigger = recording.trigger
    if trigger is None:
        return
    moves = recording.samples[0, trigger:][recording.valid[trigger:]]
    first = moves[: max(int(EARLY_SHARE * len(moves)), 8)]
    if len(moves) > 80 and float(np.ptp(first)) < EARLY_SWING * float(np.ptp(moves)):
        yield Suspicion(
            False,
            f"triggered early, by a touch: in the {len(first) / recording.rate:.2g} s after the trigger the mass "
            f"moved by only {100 * float(np.ptp(first) / np.ptp(moves)):.0f} % of its largest swing",
            "do not touch the mass while the station is armed, or raise --level",
        )
    if trigger < 0.25 * recording.rate:
        yield Suspicion(False, f"only {trigger / recording.rate:.2f} s were recorded before the release")


def wiring(recording: Recording) -> Iterator[Suspicion]:
    """Hold the two channels of a free oscillation against each other.

    About a spring's rest the acceleration opposes the displacement: a sign that does not is reversed. A
    correlation near zero means that the two measure different things. A channel that does not move at all
    says nothing of the other.
    """
    displacement, acceleration = recording.channel("displacement"), recording.channel("acceleration")
    if displacement is None or acceleration is None:
        return
    good = np.flatnonzero(recording.valid)
    good = good[good >= (recording.trigger or 0)]
    displacement, acceleration = displacement[good], acceleration[good]
    if len(displacement) < SHORTEST or not (np.ptp(displacement) and np.ptp(acceleration)):
        return
    with np.errstate(over="ignore", invalid="ignore"):  # a file may hold numbers near the largest
        x = displacement - displacement[-len(displacement) // 8 :].mean()
        a = acceleration - acceleration.mean()
        power = float(np.sqrt((x @ x) * (a @ a)))
    if not np.isfinite(power):
        return
    correlation = float(x @ a) / power if power > 0 else 0.0
    if correlation > 0.5:
        text = "displacement and acceleration have the same sign: one of them is reversed"
        yield Suspicion(True, text, "turn one sensor round, or change the sign of its scale")
    elif correlation > -0.5:
        text = (
            f"displacement and acceleration hardly agree (correlation {correlation:.2f}, near -1 expected):"
        )
        text += " swapped, or on different masses"
        yield Suspicion(False, text, "check which sensor is on which channel")
    else:
        ratio = _ratio(x, a, recording.rate)
        if not 1 / SCALE_LIMIT < ratio < SCALE_LIMIT:
            text = f"the acceleration is {ratio:.3g} times the value that displacement and frequency give:"
            text += " channels are swapped, or a scale is wrong"
            yield Suspicion(True, text, "check which sensor is on which channel, and the scales")


def _ratio(x: Array, a: Array, rate: float) -> float:
    """Return a/x over the square of the frequency at which x crosses its middle, while it is above a fifth of its largest.

    1 where it hardly crosses.
    """
    threshold = 0.2 * np.abs(x).max()
    big = np.flatnonzero(np.abs(x) > threshold)
    crossings = int(np.count_nonzero(np.diff(np.sign(x[big]))))
    if crossings < 4 or len(big) < 16:
        return 1.0
    omega = np.pi * crossings / ((big[-1] - big[0]) / rate)
    return float(np.sqrt((a @ a) / (x @ x)) / omega**2)


def _units(recording: Recording) -> Iterator[Suspicion]:
    for channel in recording.channels:
        if channel.quantity not in QUANTITIES[1:]:
            continue
        units = SI_LINEAR[channel.quantity].si, SI_ANGULAR[channel.quantity].si
        if channel.unit not in units:
            text = f"the board describes {channel.name} ({channel.quantity}) in {channel.unit!r} and not in"
            text += f" {' or '.join(units)}; its numbers were taken as they are"
            yield Suspicion(False, text, "put the factor to SI units into `scale` of the firmware")
            return


def _board_reports(assembly: Assembly) -> Iterator[Suspicion]:
    for contradiction in assembly.contradictions[:3]:
        yield Suspicion(True, f"the board contradicts itself: {contradiction}", "correct the firmware")
    faults = [e for e in assembly.events if e.kind == EventKind.SENSOR_FAULT]
    if faults:
        yield Suspicion(
            True, f"the board reports a sensor fault: {faults[0].text or 'no details'}", "check the sensor"
        )
    if assembly.rebooted:
        yield Suspicion(True, "the board rebooted in mid-capture", "check its supply")


def integrity(assembly: Assembly, remarks: list[str]) -> Iterator[Suspicion]:
    """Yield what END says against the samples; where copies of samples differ, its checksum decides which was right.

    That the checksum agrees is one of the `remarks`.
    """
    samples, end = assembly.samples, assembly.end
    problem = _contradiction(assembly, end) if end is not None else ""
    unchecked = _unchecked(assembly, problem)
    agrees = end is not None and not unchecked and samples.checksum() == end.checksum
    if problem:
        yield Suspicion(True, f"the board contradicts itself: {problem}", "correct the firmware")
    if samples.differing:
        count, first = sum(n for _, n in samples.differing), samples.differing[0][0]
        text = f"the board sent {count} samples twice with other values, from sample {first} on; the first were kept"
        text += ", and its checksum agrees with them" if agrees else ""
        yield Suspicion(not agrees, text, "correct the firmware")
    if agrees:
        remarks.append("the board's checksum of all its samples agrees")
    elif unchecked:
        yield Suspicion(False, f"the board's checksum could not be checked: {unchecked}")
    else:
        yield Suspicion(True, "the board's checksum of all samples does not agree", "take it again")


def lost_outside(assembly: Assembly) -> list[tuple[int, int]]:
    """List the samples that the checksum needs beside the recording, as (first, count), in order.

    Nothing when all samples but the dropped ones are here, or the board never said END.
    """
    samples, end, total = assembly.samples, assembly.end, assembly.total
    if end is None or end.total_dropped + samples.received >= total:
        return []
    parts = ((0, min(assembly.start, total)), (assembly.stop, total))
    return [hole for first, last in parts if last > first for hole in samples.holes(first, last)]


def _unchecked(assembly: Assembly, problem: str) -> str:
    """Say why the checksum says nothing of the samples held; "" where it does."""
    samples, end = assembly.samples, assembly.end
    if end is None:
        return "the board's END never came"
    missing = end.total_samples - end.total_dropped - samples.received
    if missing and problem:
        return "the board's END contradicts its samples"
    if not missing:
        return ""
    before = min(sum(count for _, count in samples.holes(0, assembly.start)), missing)
    parts = [f"{before} from before the recording"] if before else []
    parts += [f"{missing - before} of the recording or after it"] if missing > before else []
    return f"{missing} samples that it covers are lost, {' and '.join(parts)}"


def _contradiction(assembly: Assembly, end: End) -> str:
    samples, total, dropped = assembly.samples, end.total_samples, end.total_dropped
    said = f"END says {total} samples, {dropped} of them dropped"
    if total < samples.expected:
        return f"{said}, but sample {samples.expected - 1} had come"
    if total - samples.expected > assembly.most_missing:
        return f"{said}, but the last that came was {samples.expected - 1}"
    if dropped + samples.received > total:
        return f"{said}, but {samples.received} came"
    if assembly.losses.dropped > dropped:
        return f"{said}, but DATA counted {assembly.losses.dropped} as dropped"
    return ""
