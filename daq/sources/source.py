"""What a source of samples is: four calls. A LabJack, an NI card or a sound card is one class with these.

    class MyCard:
        def describe(self): return SourceDescription("my card", (Channel("x", "displacement", "m"),), 256.0)
        def start(self): ...                       # sample from index 0 on
        def read(self): return [Reading(first, samples)]   # what has come; waits at most about 50 ms
        def close(self): ...

`station capture --source FILE.py:MyCard` records from it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from daq.recording import Array, Channel


@dataclass(frozen=True)
class SourceDescription:
    """What a source gives: its name, its channels in SI units, and the rate in Hz.

    `remarks` are sentences for the operator, above all on the clock: whose it is, and how well the rate is known.
    """

    name: str
    channels: tuple[Channel, ...]
    rate_hz: float
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Reading:
    """Samples in SI units, shape (n, channels), n may be 0, without a hole; `first` is the first one's index since START.

    Indices that are skipped between two readings count as lost. `times_us` (n,) are the device's own times of the
    samples, None where it has no clock. `raw` are the bytes from which the samples were read, which are kept beside them.
    """

    first: int
    samples: Array
    times_us: Array | None = None
    raw: bytes = b""


class Source(Protocol):
    """Gives samples at an even rate. `read` raises LinkLost of `daq.errors` when the device is gone."""

    def describe(self) -> SourceDescription:
        """Describe what the source gives; called once, before `start`, and may listen for some seconds."""

    def start(self) -> None:
        """Sample from index 0 on."""

    def read(self) -> Sequence[Reading]:
        """Return the readings since the last call; waits at most about 50 ms."""

    def close(self) -> None:
        """Give the device back; harmless when done twice."""
