"""Whether what arrived is what the board says that it sent: END against the samples, and its checksum of them."""

from collections.abc import Iterator

from daq.decode import Assembly
from daq.wiring_check import Suspicion
from firmware_protocol import End


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

    None when all samples but the dropped ones are here, or the board never said END.
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
