"""A part of a recording as a recording of its own."""

from daq.recording import Gap, Recording


def cut(recording: Recording, start: int, stop: int) -> Recording:
    """Return samples `start` to `stop` - 1 as a recording of its own."""
    gaps = []
    for gap in recording.gaps:
        first, last = max(gap.first, start), min(gap.first + gap.count, stop)
        if last > first:
            gaps.append(Gap(first - start, last - first, gap.reason))
    return Recording(
        recording.rate,
        recording.channels,
        recording.samples[:, start:stop],
        recording.valid[start:stop],
        tuple(gaps),
        recording.rate_std,
        None,
        (*recording.notes, f"samples {start} to {stop - 1} of the file"),
        recording.run,
    )
