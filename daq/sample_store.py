"""The samples of a recording as they arrived: pieces by sample index, what is missing, their checksum, their times."""

from dataclasses import dataclass
from math import isfinite
from zlib import crc32

import numpy as np

from daq.clock import ClockFit, fit_clock
from daq.recording import Mask
from firmware_protocol import Data


@dataclass(frozen=True)
class Piece:
    """One DATA message and the host's time of its arrival (s; NaN for samples that were sent again)."""

    data: Data
    time: float

    @property
    def stop(self) -> int:
        """The sample after its last."""
        return self.data.first_index + self.data.n


class SampleStore:
    """Pieces in any order; `expected` is the sample after the newest, `duplicates` the pieces that came twice."""

    def __init__(self) -> None:
        self.expected = 0
        self.duplicates = 0
        self._pieces: dict[int, Piece] = {}

    def __bool__(self) -> bool:
        return bool(self._pieces)

    @property
    def first(self) -> int:
        """The first sample that arrived; 0 when there is none."""
        return min(self._pieces, default=0)

    def add(self, piece: Piece) -> bool:
        """Store a piece unless the one stored at that place is as long; return whether it is new."""
        known = self._pieces.get(piece.data.first_index)
        if known is not None and known.data.n >= piece.data.n:
            self.duplicates += 1
            return False
        self._pieces[piece.data.first_index] = piece
        self.expected = max(self.expected, piece.stop)
        return True

    def within(self, first: int, stop: int) -> list[Piece]:
        """Return the pieces that hold any of samples `first` to `stop - 1`."""
        return [p for p in self._pieces.values() if p.data.first_index < stop and p.stop > first]

    def mask(self, first: int, stop: int) -> Mask:
        """Return which of samples `first` to `stop - 1` arrived, shape (stop - first,)."""
        valid = np.zeros(max(stop - first, 0), dtype=np.bool_)
        for piece in self.within(first, stop):
            valid[max(piece.data.first_index - first, 0) : piece.stop - first] = True
        return valid

    def checksum(self) -> tuple[int, int]:
        """Return how many samples there are and the CRC-32 of all their bytes, in order."""
        check, at, count = 0, 0, 0
        for piece in sorted(self._pieces.values(), key=lambda p: p.data.first_index):
            data, known = piece.data, max(at - piece.data.first_index, 0)
            check = crc32(data.samples[known * data.channels * data.format.size :], check)
            count += max(data.n - known, 0)
            at = max(at, piece.stop)
        return count, check

    def board_clock(self) -> ClockFit | None:
        """The rate by the board's own times of its samples; None with too few."""
        pieces = self._pieces.values()
        return fit_clock([p.data.first_index for p in pieces], [p.data.board_time_us * 1e-6 for p in pieces])

    def host_clock(self) -> ClockFit | None:
        """The rate by the times at which samples reached the host before END; None with too few."""
        pieces = [p for p in self._pieces.values() if isfinite(p.time)]
        return fit_clock([p.stop for p in pieces], [p.time for p in pieces])
