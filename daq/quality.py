"""The verdict on a recording: OK, USABLE WITH GAPS or REJECT, with the reasons in words.

It judges what was recorded, not what it means: losses, a dead channel, too little motion, faults of the sensors, a
start in mid-motion, noise, clocks, channels that contradict each other.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from enum import StrEnum

import numpy as np
from pydantic import AliasChoices, BaseModel, ConfigDict, Field

from daq.clock_check import checked_rate
from daq.decode import IMPORT, Assembly
from daq.description_checks import foreign_unit
from daq.integrity import Outcome
from daq.recording import Array, Channel, Gap, Recording
from daq.sensor_faults import SensorFaults, sensor_faults
from daq.wiring_check import Suspicion, suspicions
from firmware_protocol import EventKind

LOST_LIMIT = 0.02
LONGEST_GAP_S = 0.25
MOTION_TO_NOISE = 20.0
NOISIER_LIMIT = 3.0
EARLY_SHARE = 0.1
EARLY_SWING = 0.25


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

    def __str__(self) -> str:
        return "\n".join((self.grade.value, *(f"- {reason}" for reason in self.reasons)))


class _Findings:
    def __init__(self) -> None:
        self.found: list[tuple[Grade, str, str]] = []
        self.remarks: list[str] = []

    def reject(self, reason: str, advice: str = "") -> None:
        self.found.append((Grade.REJECT, reason, advice))

    def usable(self, reason: str, advice: str = "") -> None:
        self.found.append((Grade.USABLE, reason, advice))

    def suspect(self, *suspicions: Suspicion) -> None:
        for found in suspicions:
            (self.reject if found.certain else self.usable)(found.reason, found.advice)

    def verdict(self) -> Verdict:
        for grade in (Grade.REJECT, Grade.USABLE):
            if any(found[0] is grade for found in self.found):
                break
        else:
            return Verdict(grade=Grade.OK, remarks=tuple(self.remarks))
        ordered = sorted(self.found, key=lambda found: found[0] is not Grade.REJECT)
        advice = dict.fromkeys(found[2] for found in ordered if found[2])
        reasons = tuple(found[1] for found in ordered)
        return Verdict(grade=grade, reasons=reasons, advice=tuple(advice), remarks=tuple(self.remarks))


@np.errstate(over="ignore", invalid="ignore")  # numbers of a board may be anything
def judge(
    recording: Recording,
    assembly: Assembly | None = None,
    planned: int | None = None,
    noise: Mapping[str, float] | None = None,
    check_clock: bool = True,
    typical: Mapping[str, float] | None = None,
    sensors: SensorFaults | None = None,
) -> Verdict:
    """Return the verdict on a recording.

    `assembly` adds what the board and the wire reported, `planned` the number of samples wanted, `noise` the
    standard deviation of each channel at rest by its name (channel's unit), `typical` the same in other sessions,
    `sensors` what `sensor_faults` found where that is known.
    """
    findings = _Findings()
    _losses(findings, recording, planned)
    for channel, samples in zip(recording.channels, recording.samples, strict=True):
        _one_channel(findings, channel, samples[recording.valid], (noise or {}).get(channel.name))
    _noisier(findings, recording, noise or {}, typical or {})
    sensors = sensors or sensor_faults(recording, assembly)
    findings.suspect(*sensors.suspicions)
    _start(findings, recording)
    _kinematics(findings, recording)
    if assembly is not None:
        _board_reports(findings, assembly)
        if assembly.origin != IMPORT:
            _integrity(findings, assembly)
            findings.suspect(*checked_rate(assembly, check_clock).suspicions)
    return findings.verdict()


def summary(gaps: Iterable[Gap]) -> str:
    """Return lost samples by reason: `16 on the wire, 32 by overrun of the board`."""
    words = {
        "wire": "on the wire",
        "overrun": "by overrun of the board",
        "reboot": "by a reboot of the board",
        "checksum": "to a wrong checksum",
    }
    counts: Counter[str] = Counter()
    for gap in gaps:
        counts[gap.reason] += gap.count
    return ", ".join(f"{n} {words.get(reason, f'({reason})')}" for reason, n in counts.items())


def _losses(findings: _Findings, recording: Recording, planned: int | None) -> None:
    n = len(recording.valid)
    lost = int(n - recording.valid.sum())
    if planned is not None and n < planned:
        share = n / planned
        say = findings.reject if share < 0.5 else findings.usable
        say(
            f"ends {(planned - n) / recording.rate:.2f} s early, after {n} of {planned} samples",
            "check cable and board",
        )
    if not lost:
        return
    longest = max((gap.count for gap in recording.gaps), default=lost) / recording.rate
    reason = f"{lost} of {n} samples lost: {summary(recording.gaps)}; the longest gap {longest * 1e3:.0f} ms"
    if recording.trigger is not None and recording.valid[recording.trigger :].all():
        reason += ", all before the release"
    advice = "a shorter cable, a slower rate, or a faster port"
    if lost > LOST_LIMIT * n or longest > LONGEST_GAP_S:
        findings.reject(reason, advice)
    else:
        findings.usable(reason, advice)


def _one_channel(findings: _Findings, channel: Channel, samples: Array, noise: float | None) -> None:
    if not len(samples):
        return
    span = float(np.ptp(samples))
    step = channel.resolution or 0.0
    if span <= step:
        findings.reject(
            f"{channel.name} does not move: dead, or not connected", f"check the sensor of {channel.name}"
        )
        return
    if noise is not None and span < MOTION_TO_NOISE * noise:
        findings.reject(
            f"{channel.name} moves by only {span / noise:.0f} times its noise", "a larger release"
        )


def _noisier(
    findings: _Findings, recording: Recording, noise: Mapping[str, float], typical: Mapping[str, float]
) -> None:
    """Noise far above that of the same board's other sessions means a loose cable or a shaken bench."""
    for channel in recording.channels:
        now, before = noise.get(channel.name, 0.0), typical.get(channel.name, 0.0)
        if before > 0.0 and now > NOISIER_LIMIT * before:
            findings.usable(
                f"{channel.name} is {now / before:.1f} times as noisy at rest as usual "
                f"({now:.2g} {channel.unit}, usually {before:.2g})",
                f"look for a loose cable of {channel.name}, or for what shakes the bench",
            )


def _start(findings: _Findings, recording: Recording) -> None:
    """A capture that begins in mid-motion has missed its release; one that a touch has set off comes too early."""
    trigger = recording.trigger
    if trigger is None:
        return
    moves = recording.samples[0, trigger:][recording.valid[trigger:]]
    first = moves[: max(int(EARLY_SHARE * len(moves)), 8)]
    if len(moves) > 80 and float(np.ptp(first)) < EARLY_SWING * float(np.ptp(moves)):
        findings.usable(
            f"triggered early, by a touch: in the {len(first) / recording.rate:.2g} s after the trigger the mass "
            f"moved by only {100 * float(np.ptp(first) / np.ptp(moves)):.0f} % of its largest swing",
            "do not touch the mass while the station is armed, or raise --level",
        )
    if trigger < 0.25 * recording.rate:
        findings.usable(f"only {trigger / recording.rate:.2f} s were recorded before the release")


def _kinematics(findings: _Findings, recording: Recording) -> None:
    """Hold the two channels of a free oscillation against each other."""
    displacement, acceleration = recording.channel("displacement"), recording.channel("acceleration")
    if displacement is None or acceleration is None:
        return
    good = np.flatnonzero(recording.valid)
    good = good[good >= (recording.trigger or 0)]
    findings.suspect(*suspicions(displacement[good], acceleration[good], recording.rate))


def _board_reports(findings: _Findings, assembly: Assembly) -> None:
    for contradiction in assembly.contradictions[:3]:
        findings.reject(f"the board contradicts itself: {contradiction}", "correct the firmware")
    faults = [e for e in assembly.events if e.kind == EventKind.SENSOR_FAULT]
    if faults:
        findings.reject(
            f"the board reports a sensor fault: {faults[0].text or 'no details'}", "check the sensor"
        )
    if assembly.rebooted:
        findings.reject("the board rebooted in mid-capture", "check its supply")


def _integrity(findings: _Findings, assembly: Assembly) -> None:
    """Hold the samples against DESCRIBE and END; where copies of samples differ, the checksum decides which was right."""
    if assembly.description is not None and (unit := foreign_unit(assembly.description)):
        findings.usable(unit, "put the factor to SI units into `scale` of the firmware")
    found = assembly.integrity()
    if found.problem:
        findings.reject(f"the board contradicts itself: {found.problem}", "correct the firmware")
    differing = assembly.samples.differing
    if differing:
        count, first = sum(n for _, n in differing), differing[0][0]
        text = f"the board sent {count} samples twice with other values, from sample {first} on; the first were kept"
        if found.checksum is Outcome.AGREES:
            findings.usable(f"{text}, and its checksum agrees with them", "correct the firmware")
        else:
            findings.reject(text, "correct the firmware")
    if found.checksum is Outcome.AGREES:
        findings.remarks.append("the board's checksum of all its samples agrees")
    elif found.checksum is Outcome.DIFFERS:
        findings.reject("the board's checksum of all samples does not agree", "take it again")
    else:
        findings.usable(f"the board's checksum could not be checked: {found.why}")
