"""The samples of a recording as they arrived: first copies, their times and checksum; what is missing, and why."""

from bisect import bisect_right
from dataclasses import dataclass, replace
from math import isfinite
from zlib import crc32

import numpy as np

from daq.clock import ClockFit, Unevenness, fit_arrivals, fit_clock, lasting_step, unevenness
from daq.recording import Gap, Mask
from firmware_protocol import Data

MOST_DIFFERING = 200
MOST_OVERRUNS = 20_000


@dataclass(frozen=True)
class Piece:
    """One DATA message, or a part of it, and the host's time of its arrival (s; NaN for samples sent again)."""

    data: Data
    time: float

    @property
    def first(self) -> int:
        """Its first sample."""
        return self.data.first_index

    @property
    def stop(self) -> int:
        """The sample after its last."""
        return self.data.first_index + self.data.n

    def bytes_of(self, first: int, stop: int) -> bytes:
        """Return the bytes of samples `first` to `stop - 1`, all of them in this piece."""
        size = self.data.channels * self.data.format.size
        return self.data.samples[(first - self.first) * size : (stop - self.first) * size]

    def part(self, first: int, stop: int) -> "Piece":
        """Return samples `first` to `stop - 1` of it as a piece."""
        if (first, stop) == (self.first, self.stop):
            return self
        cut = replace(self.data, first_index=first, n=stop - first, samples=self.bytes_of(first, stop))
        return Piece(cut, self.time)


class SampleStore:
    """Pieces that do not overlap, by sample index: the first copy of a sample stays, whatever comes later.

    All pieces have the same channels and number format. `expected` is the sample after the newest, `received` how
    many samples are held, `duplicates` the frames that brought nothing new, `differing` where a later copy of
    samples was not the same, as (first, count).
    """

    def __init__(self) -> None:
        self.expected = 0
        self.received = 0
        self.duplicates = 0
        self.differing: list[tuple[int, int]] = []
        self._pieces: list[Piece] = []
        self._starts: list[int] = []
        self._stamps: dict[int, int] = {}

    def __bool__(self) -> bool:
        return bool(self._pieces)

    @property
    def first(self) -> int:
        """The first sample that arrived; 0 when there is none."""
        return self._starts[0] if self._starts else 0

    def add(self, piece: Piece) -> tuple[Piece, ...]:
        """Store what is not held yet of a piece, and return it in order; empty when all of it was held."""
        new = (piece,) if piece.first >= self.expected else self._parts_in_holes(piece)
        if not new:
            self.duplicates += 1
            return ()
        self._stamps.setdefault(piece.first, piece.data.board_time_us)
        for part in new:
            at = bisect_right(self._starts, part.first)
            self._pieces.insert(at, part)
            self._starts.insert(at, part.first)
            self.received += part.data.n
        self.expected = max(self.expected, piece.stop)
        return new

    def _parts_in_holes(self, piece: Piece) -> tuple[Piece, ...]:
        new, at = [], piece.first
        for known in self.within(piece.first, piece.stop):
            if known.first > at:
                new.append(piece.part(at, known.first))
            self._compare(known, piece, max(known.first, piece.first), min(known.stop, piece.stop))
            at = known.stop
        if at < piece.stop:
            new.append(piece.part(at, piece.stop))
        return tuple(new)

    def _compare(self, known: Piece, again: Piece, first: int, stop: int) -> None:
        """Note where two copies of samples `first` to `stop - 1` differ."""
        if known.bytes_of(first, stop) == again.bytes_of(first, stop):
            return
        other = [i for i in range(first, stop) if known.bytes_of(i, i + 1) != again.bytes_of(i, i + 1)]
        if len(self.differing) < MOST_DIFFERING:
            self.differing.append((other[0], len(other)))

    def within(self, first: int, stop: int) -> list[Piece]:
        """Return the pieces that hold any of samples `first` to `stop - 1`, in order."""
        begin = max(bisect_right(self._starts, first) - 1, 0)
        end = bisect_right(self._starts, stop - 1)
        return [piece for piece in self._pieces[begin:end] if piece.stop > first]

    def holes(self, first: int, stop: int) -> list[tuple[int, int]]:
        """Return the runs of samples of `first` to `stop - 1` that are not held, as (first, count), in order."""
        found, at = [], first
        for piece in self.within(first, stop):
            if piece.first > at:
                found.append((at, piece.first - at))
            at = piece.stop
        if at < stop:
            found.append((at, stop - at))
        return found

    def mask(self, first: int, stop: int) -> Mask:
        """Return which of samples `first` to `stop - 1` arrived, shape (stop - first,)."""
        valid = np.zeros(max(stop - first, 0), dtype=np.bool_)
        for piece in self.within(first, stop):
            valid[max(piece.first - first, 0) : piece.stop - first] = True
        return valid

    def checksum(self) -> int:
        """Return the CRC-32 of the bytes of all samples held, in order."""
        check = 0
        for piece in self._pieces:
            check = crc32(piece.data.samples, check)
        return check

    def board_clock(self) -> ClockFit | None:
        """The rate by the board's own times of its samples; None with too few."""
        return fit_clock(list(self._stamps), [us * 1e-6 for us in self._stamps.values()])

    def clock_stands_still(self) -> bool:
        """Check whether the board gave all its samples one time."""
        return len(self._stamps) > 1 and len(set(self._stamps.values())) == 1

    def unevenness(self, first: int, stop: int) -> Unevenness | None:
        """How far the board's times about samples `first` to `stop - 1` part from even ones; None with too few."""
        known = sorted(self._stamps)
        known = known[max(bisect_right(known, first) - 1, 0) : bisect_right(known, stop - 1) + 1]
        return unevenness(known, [self._stamps[index] for index in known])

    def host_clock(self) -> ClockFit | None:
        """The rate by the times at which samples reached the host before END; None with too few."""
        return fit_arrivals(*self._arrivals())

    def lasting_step(self) -> Unevenness | None:
        """Where samples begin to reach the host later, or earlier, for good; None where they do not."""
        return lasting_step(*self._arrivals())

    def usual_length(self) -> float:
        """How many samples a DATA message holds, the median; 0 without any."""
        held = [p.data.n for p in self._pieces if isfinite(p.time)]
        return float(np.median(held)) if held else 0.0

    def _arrivals(self) -> tuple[list[int], list[float]]:
        pieces = [p for p in self._pieces if isfinite(p.time)]
        return [p.stop for p in pieces], [p.time for p in pieces]


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
        runs = zip([0, *edges.tolist()], [*edges.tolist(), len(valid)], strict=True)
        return tuple(Gap(first + a, b - a, reasons[a]) for a, b in runs if reasons[a] is not None)
