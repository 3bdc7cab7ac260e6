"""Whether what arrived is what the board says that it sent: the checksum of END, and END against the samples."""

from dataclasses import dataclass
from enum import StrEnum

from daq.losses import Losses
from daq.sample_store import SampleStore
from firmware_protocol import End


class Outcome(StrEnum):
    """What the checksum over all samples since START says."""

    AGREES = "agrees"
    DIFFERS = "differs"
    UNCHECKED = "could not be checked"


@dataclass(frozen=True)
class Integrity:
    """The outcome of the checksum and, where it could not be checked, why; `problem` is how END contradicts."""

    checksum: Outcome
    why: str = ""
    problem: str = ""


def integrity(samples: SampleStore, losses: Losses, end: End | None, start: int, most: int) -> Integrity:
    """Compare END with the samples held, of which those before `start` are not part of the recording.

    `most` is how many samples may be missing at most for END to be believed.
    """
    if end is None:
        return Integrity(Outcome.UNCHECKED, "the board's END never came")
    total, dropped = end.total_samples, end.total_dropped
    problem = _contradiction(samples, losses, end, most)
    missing = total - dropped - samples.received
    if missing == 0:
        agrees = samples.checksum() == end.checksum
        return Integrity(Outcome.AGREES if agrees else Outcome.DIFFERS, "", problem)
    if problem:
        return Integrity(Outcome.UNCHECKED, "the board's END contradicts its samples", problem)
    before = min(sum(count for _, count in samples.holes(0, start)), missing)
    parts = [f"{before} from before the recording"] if before else []
    parts += [f"{missing - before} of the recording or after it"] if missing > before else []
    return Integrity(Outcome.UNCHECKED, f"{missing} samples that it covers are lost, {' and '.join(parts)}")


def lost_outside(
    samples: SampleStore, end: End | None, start: int, stop: int, total: int
) -> list[tuple[int, int]]:
    """List the samples that the checksum needs beside `start` to `stop - 1`, as (first, count), in order.

    None when all `total` samples but the dropped ones are here, or the board never said END.
    """
    if end is None or end.total_dropped + samples.received >= total:
        return []
    parts = ((0, min(start, total)), (stop, total))
    return [hole for first, last in parts if last > first for hole in samples.holes(first, last)]


def _contradiction(samples: SampleStore, losses: Losses, end: End, most: int) -> str:
    total, dropped = end.total_samples, end.total_dropped
    said = f"END says {total} samples, {dropped} of them dropped"
    if total < samples.expected:
        return f"{said}, but sample {samples.expected - 1} had come"
    if total - samples.expected > most:
        return f"{said}, but the last that came was {samples.expected - 1}"
    if dropped + samples.received > total:
        return f"{said}, but {samples.received} came"
    if losses.dropped > dropped:
        return f"{said}, but DATA counted {losses.dropped} as dropped"
    return ""
