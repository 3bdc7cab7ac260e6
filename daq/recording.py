"""A recording: samples on the board's clock, with the lost ones marked."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from daq.plain_text import one_line

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Index = NDArray[np.int64]
MOTIONS = ("displacement", "velocity", "acceleration")


def runs(mask: Mask) -> list[tuple[int, int]]:
    """Return the runs of True in a mask, shape (n,), as (first, one past the last), in order."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], mask, [False])).astype(np.int8)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


@dataclass(frozen=True)
class Channel:
    """What one channel measures: `quantity` is displacement, velocity, acceleration, force or other.

    `unit` is the SI unit of the samples as they stand in a `Recording` (m, rad, m/s, rad/s, m/s^2, N ...).
    `resolution` (one code of the converter), `low` and `high` (the range) are in that unit.
    """

    name: str
    quantity: str
    unit: str
    resolution: float | None = None
    low: float | None = None
    high: float | None = None
    group_delay_s: float = 0.0
    sensor: str = ""
    calibration_uncertainty: float | None = None

    def __post_init__(self) -> None:
        """Make the texts one line each: they come from boards and files."""
        for name in ("name", "quantity", "unit", "sensor"):
            object.__setattr__(self, name, one_line(getattr(self, name)))


@dataclass(frozen=True)
class Gap:
    """Samples `first` to `first + count - 1` that were lost, and why (wire, overrun, reboot)."""

    first: int
    count: int
    reason: str


@dataclass(frozen=True)
class Suspicion:
    """What speaks against a recording, and what to do about it ("" for nothing); `certain` ones reject it."""

    certain: bool
    reason: str
    advice: str = ""


@dataclass(frozen=True, eq=False)
class Recording:
    """Samples in SI units, shape (channels, n), at `rate` Hz; `valid` (n,) is False where they were lost.

    `rate_std` is the standard error of the rate in Hz (None where the rate was given), `trigger` the sample at which
    the station saw the release during the capture (None for imports), `notes` what was understood or
    guessed on the way in, a sentence each, `run` the name of the run in a file that holds several. `as_read` are the rows
    themselves, one a sample, where the samples are those of a curve through them.
    """

    rate: float
    channels: tuple[Channel, ...]
    samples: Array
    valid: Mask
    gaps: tuple[Gap, ...] = ()
    rate_std: float | None = None
    trigger: int | None = None
    notes: tuple[str, ...] = ()
    run: str = ""
    as_read: "Recording | None" = None

    def __post_init__(self) -> None:
        samples = np.array(self.samples, dtype=np.float64)
        valid = np.array(self.valid, dtype=np.bool_)
        if samples.ndim != 2 or samples.shape[0] != len(self.channels) or samples.shape[1] != len(valid):
            raise ValueError(f"samples {samples.shape}, {len(self.channels)} channels, mask {valid.shape}")
        samples.setflags(write=False)
        valid.setflags(write=False)
        object.__setattr__(self, "samples", samples)
        object.__setattr__(self, "valid", valid)

    def channel(self, quantity: str) -> Array | None:
        """Return the samples of the first channel of that quantity, shape (n,), or None."""
        for channel, samples in zip(self.channels, self.samples, strict=True):
            if channel.quantity == quantity:
                found: Array = samples
                return found
        return None


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
        as_read=None if recording.as_read is None else cut(recording.as_read, start, stop),
    )
