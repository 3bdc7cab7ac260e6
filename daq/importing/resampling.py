"""The rows of a table on an even clock, where what is missing stays missing, and a part of them."""

from dataclasses import replace

import numpy as np

from daq.importing.timebase import Timebase
from daq.recording import Array, Gap, Mask, Recording, runs


def place(values: Array, clock: Timebase, *, resample: bool) -> tuple[Array, Mask]:
    """Return the samples on the even clock, shape (channels, count), and the mask of those that are there."""
    there = np.isfinite(values).all(axis=0)
    valid = np.zeros(clock.count, dtype=bool)
    samples = np.full((len(values), clock.count), np.nan)
    samples[:, clock.index] = values
    valid[clock.index] = there
    if not resample or clock.stamps is None or np.count_nonzero(there) < 4:
        return samples, valid
    return _resampled(values[:, there], clock.stamps[there], clock)


def _resampled(values: Array, stamps: Array, clock: Timebase) -> tuple[Array, Mask]:
    """Return a cubic spline through the stamped samples on the even clock; holes wider than 1.5 periods stay holes."""
    from scipy.interpolate import CubicSpline

    grid = np.arange(clock.count) / clock.rate
    stamps, first = np.unique(stamps, return_index=True)
    samples = np.asarray(CubicSpline(stamps, values[:, first], axis=1)(grid))
    after = np.clip(np.searchsorted(stamps, grid), 1, len(stamps) - 1)
    width = stamps[after] - stamps[after - 1]
    near = np.minimum(np.abs(grid - stamps[after]), np.abs(grid - stamps[after - 1]))
    period = 1.0 / clock.rate
    inside = (grid >= stamps[0] - 0.5 * period) & (grid <= stamps[-1] + 0.5 * period)
    valid = inside & ((width < 1.75 * period) | (near < 0.25 * period))
    valid &= np.isfinite(samples).all(axis=0)
    return np.where(valid, samples, np.nan), valid


def find_gaps(valid: Mask, clock: Timebase) -> tuple[Gap, ...]:
    """Return the runs of invalid samples: missing from the file, or there without a number."""
    present = np.zeros(clock.count, dtype=bool)
    present[clock.index] = True
    return tuple(
        Gap(a, b - a, "no number in the file" if present[a:b].any() else "missing from the file")
        for a, b in runs(~valid)
    )


def cut(recording: Recording, start: int, stop: int) -> Recording:
    """Return samples `start` to `stop` - 1 as a recording of its own."""
    gaps = []
    for gap in recording.gaps:
        first, last = max(gap.first, start), min(gap.first + gap.count, stop)
        if last > first:
            gaps.append(Gap(first - start, last - first, gap.reason))
    return replace(
        recording,
        samples=recording.samples[:, start:stop],
        valid=recording.valid[start:stop],
        gaps=tuple(gaps),
        notes=(*recording.notes, f"samples {start} to {stop - 1} of the file"),
    )
