"""The samples of a recording as they arrived: first copies, their times and checksum; what is missing, and why."""

from bisect import bisect_right
from math import isfinite
from zlib import crc32

import numpy as np

from daq.clock import ClockFit, Unevenness, fit_arrivals, fit_clock, unevenness
from daq.recording import Gap, Mask, runs
from firmware_protocol import Data

MOST_DIFFERING = 200
MOST_OVERRUNS = 20_000


class SampleStore:
    """Samples by index, one behind the other: the first copy of a sample stays, whatever comes later.

    All DATA have the same channels and number format. `received` is how many samples are held, `duplicates` the frames
    that brought nothing new, `differing` where a later copy of samples was not the same, as (first, count).
    `stamps` are the board's times (us) of the first samples of messages; `arrivals` say of each message how many samples it
    brought, the one after them, and when it came (s).
    """

    def __init__(self) -> None:
        self.received = 0
        self.duplicates = 0
        self.differing: list[tuple[int, int]] = []
        self._bytes = bytearray()  # of each sample, zeros where it is missing
        self._held = bytearray()  # 1 for each sample that is held
        self.stamps: dict[int, int] = {}
        self.arrivals: list[tuple[int, int, float]] = []

    @property
    def expected(self) -> int:
        """The sample after the newest."""
        return len(self._held)

    @property
    def first(self) -> int:
        """The first sample that arrived; 0 when there is none."""
        return max(self._held.find(1), 0)

    def add(self, data: Data, time: float) -> list[tuple[int, int]]:
        """Store what is not held yet of a message that came at `time` (s; NaN for samples sent again).

        Return the runs that were new, within the message, as (first, one past the last); none when all were held.
        """
        size, first, stop = data.channels * data.format.size, data.first_index, data.first_index + data.n
        late, beyond = first < self.expected, max(stop - self.expected, 0)
        self._bytes += bytes(beyond * size)
        self._held += bytes(beyond)
        new = [(0, data.n)]
        if late:
            held = self.mask(first, stop)
            self._compare(data, held, size)
            new = runs(~held)
        if not new:
            self.duplicates += 1
            return []
        for a, b in new:
            self._bytes[(first + a) * size : (first + b) * size] = data.samples[a * size : b * size]
            self._held[first + a : first + b] = b"\1" * (b - a)
            self.received += b - a
        self.stamps.setdefault(first, data.board_time_us)
        if isfinite(time):
            self.arrivals.append((data.n, stop, time))
        return new

    def _compare(self, data: Data, held: Mask, size: int) -> None:
        """Note where the samples of a message differ from those that are `held`, shape (n,), of it."""
        known = np.frombuffer(self.bytes_of(data.first_index, data.first_index + data.n), np.uint8)
        again = np.frombuffer(data.samples, np.uint8)
        other = held & (known != again).reshape(-1, size).any(axis=1)
        if other.any() and len(self.differing) < MOST_DIFFERING:
            self.differing.append((data.first_index + int(np.argmax(other)), int(other.sum())))

    def bytes_of(self, first: int, stop: int) -> bytes:
        """Return the bytes of samples `first` to `stop - 1`, as far as any came; zeros where one is missing."""
        size = len(self._bytes) // max(self.expected, 1)
        return bytes(self._bytes[first * size : stop * size])

    def mask(self, first: int, stop: int) -> Mask:
        """Return which of samples `first` to `stop - 1` arrived, shape (stop - first,)."""
        valid = np.zeros(max(stop - first, 0), dtype=np.bool_)
        known = np.frombuffer(bytes(self._held[first:stop]), np.bool_)
        valid[: len(known)] = known
        return valid

    def holes(self, first: int, stop: int) -> list[tuple[int, int]]:
        """Return the runs of samples of `first` to `stop - 1` that are not held, as (first, count), in order."""
        return [(first + a, b - a) for a, b in runs(~self.mask(first, stop))]

    def checksum(self) -> int:
        """Return the CRC-32 of the bytes of all samples held, in order."""
        check = 0
        for a, b in runs(self.mask(0, self.expected)):
            check = crc32(self.bytes_of(a, b), check)
        return check

    def board_clock(self) -> ClockFit | None:
        """The rate by the board's own times of its samples; None with too few."""
        return fit_clock(list(self.stamps), [us * 1e-6 for us in self.stamps.values()])

    def unevenness(self, first: int, stop: int) -> Unevenness | None:
        """How far the board's times about samples `first` to `stop - 1` part from even ones; None with too few."""
        known = sorted(self.stamps)
        known = known[max(bisect_right(known, first) - 1, 0) : bisect_right(known, stop - 1) + 1]
        return unevenness(known, [self.stamps[index] for index in known])

    def host_clock(self) -> ClockFit | None:
        """The rate by the times at which samples reached the host before END; None with too few."""
        return fit_arrivals([stop for _, stop, _ in self.arrivals], [time for *_, time in self.arrivals])


class Losses:
    """What the board and the notes of an import said of missing samples; `dropped` by its DATA, in all."""

    def __init__(self) -> None:
        self.noted: list[Gap] = []
        self.dropped = 0
        self._overruns: list[tuple[int, int]] = []

    def clear(self) -> None:
        """Forget the overruns of an earlier capture."""
        self.dropped = 0
        self._overruns.clear()

    def overrun(self, first: int, stop: int) -> None:
        """Take note that the board dropped samples `first` to `stop - 1`."""
        if len(self._overruns) < MOST_OVERRUNS:
            self._overruns.append((max(first, 0), stop))

    def before(self, first: int, expected: int, dropped: int) -> tuple[Gap, ...]:
        """Return the gaps between the sample expected and the next to come, of which the board dropped some."""
        count = first - expected
        dropped = min(dropped, count)
        wire = count - dropped
        if self.noted:
            return tuple(gap for gap in self.noted if expected <= gap.first < first)
        lost = (Gap(expected, wire, "wire"), Gap(expected + wire, dropped, "overrun"))
        return tuple(gap for gap in lost if gap.count)

    def gaps(self, valid: Mask, arrived: Mask, first: int, rebooted_at: int | None) -> tuple[Gap, ...]:
        """Return the runs of invalid samples with their reasons.

        `valid` and `arrived`, shape (n,), begin at sample `first`; `rebooted_at` is the first sample that a
        reboot cost, None without one.
        """
        if valid.all():
            return ()
        reasons = np.full(len(valid), "wire", dtype=object)
        reasons[arrived] = "not a number"
        for a, b in self._overruns:
            part = slice(max(a - first, 0), max(b - first, 0))
            reasons[part][~arrived[part]] = "overrun"
        for gap in self.noted:
            reasons[max(gap.first - first, 0) : max(gap.first + gap.count - first, 0)] = gap.reason
        if rebooted_at is not None:
            reasons[max(rebooted_at - first, 0) :] = "reboot"
        reasons[valid] = None
        edges = np.flatnonzero(reasons[1:] != reasons[:-1]) + 1
        parts = zip([0, *edges.tolist()], [*edges.tolist(), len(valid)], strict=True)
        return tuple(Gap(first + a, b - a, reasons[a]) for a, b in parts if reasons[a] is not None)
