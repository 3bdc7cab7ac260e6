"""From messages to a recording: the one way used live, in a replay and when a session is read.

`Assembly` takes frames in the order of their arrival. The sample index is the time axis; the frames'
order, `dropped_before` and `boot_id` distinguish a frame lost on the wire from an overrun of the board
and from a board that rebooted. Nothing that arrives makes it raise: what contradicts the protocol is listed in
`contradictions`, and what a capture does about it is the capture's affair.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import isfinite
from typing import Any
from zlib import crc32

import numpy as np

from daq.clock import ClockFit, fit_clock
from daq.description_checks import Window, channels_of, gap_of, items_of, problem_of, window_of
from daq.errors import DataLost
from daq.raw_log import Kind, Record
from daq.recording import Array, Channel, Gap, Mask, Recording
from firmware_protocol import Data, Decoder, Describe, End, Event, EventKind, Frame, Hello, Log

MAX_MISSING = 1 << 22
MAX_LISTED = 200


@dataclass(frozen=True, eq=False)
class Block:
    """Samples from `first` on in SI units, shape (channels, n), that reached the host at `time`."""

    first: int
    samples: Array
    time: float


@dataclass(frozen=True)
class _Piece:
    data: Data
    time: float

    @property
    def stop(self) -> int:
        return self.data.first_index + self.data.n


class Assembly:
    """Puts messages together; `recording()` may be asked at any time for what is there so far."""

    def __init__(self) -> None:
        self.hello: Hello | None = None
        self.description: Describe | None = None
        self.end: End | None = None
        self.window: Window | None = None
        self.rebooted = False
        self.expected = 0
        self.frames = 0
        self.duplicates = 0
        self.notes: list[str] = []
        self.events: list[Event] = []
        self.contradictions: list[str] = []
        self._pieces: dict[int, _Piece] = {}
        self._overruns: list[tuple[int, int]] = []
        self._reasons: list[Gap] = []
        self._missing = 0
        self._sequence = -1

    def take(self, frame: Frame, time: float) -> tuple[Block | Gap, ...]:
        """Take one frame; return the samples it brought and, before them, what was found missing."""
        message = frame.message
        self.frames += 1
        if isinstance(message, Data):
            return self._take_data(frame.sequence, message, time)
        if isinstance(message, Hello):
            return self._take_hello(message)
        if isinstance(message, Describe):
            self._take_description(message)
        elif isinstance(message, End):
            self.end = message
        elif isinstance(message, Event):
            self._take_event(message)
        elif isinstance(message, Log):
            _list(self.notes, f"the board said: {message.text}")
        return ()

    def take_note(self, note: dict[str, Any]) -> None:
        """Take what the station wrote down between the bytes; what is not understood is skipped."""
        if note.get("event") == "window":
            self.window = window_of(note) or self.window
        elif note.get("event") == "start":
            self._forget_samples()
        elif note.get("event") == "imported":
            self._reasons = [gap for item in items_of(note, "gaps") if (gap := gap_of(item)) is not None]
            self.notes += [item for item in items_of(note, "notes") if isinstance(item, str)]

    @property
    def rate(self) -> float:
        """Samples per second by the board's description; 0 before it came."""
        return self.description.channels[0].rate_hz if self.description else 0.0

    @property
    def channels(self) -> tuple[Channel, ...]:
        """The channels by the board's description; empty before it came."""
        return channels_of(self.description) if self.description else ()

    @property
    def start(self) -> int:
        """The first sample of the recording: the window's, else the first that arrived."""
        if self.window is not None:
            return self.window.first
        return min(self._pieces, default=0)

    @property
    def stop(self) -> int:
        """The sample after the recording's last.

        Up to the window's end, as far as samples were taken; a stream that merely stopped ends with the
        last sample received, one whose board rebooted or said END is known to be short by so many.
        """
        if self.window is None:
            return max(self.expected, self._total())
        planned = self.window.first + self.window.count
        if self.rebooted:
            return planned
        return min(planned, max(self.expected, self._total()))

    def _total(self) -> int:
        """How many samples the board says it took, if that is believable."""
        total = self.end.total_samples if self.end else 0
        return total if total - self.expected <= MAX_MISSING else 0

    def missing(self) -> tuple[Gap, ...]:
        """Return what is missing from the recording so far, with reasons."""
        return self._gaps(self._mask(self.start, self.stop), self.start)

    def recording(self, notes: Iterable[str] = ()) -> Recording:
        """Return the recording; lost samples are NaN and not `valid`. DataLost when there are none at all."""
        channels, first, stop = self.channels, self.start, self.stop
        if not self._pieces or not channels or stop <= first:
            raise DataLost("no sample was received, so there is nothing to read")
        samples = np.full((len(channels), stop - first), np.nan)
        for piece in self._within(first, stop):
            at = piece.data.first_index - first
            block = self._convert(piece.data)[:, max(-at, 0) : stop - first - at]
            samples[:, max(at, 0) : max(at, 0) + block.shape[1]] = block
        valid = np.isfinite(samples).all(axis=0)
        samples[:, ~valid] = np.nan
        trigger = self.window.trigger if self.window else None
        return Recording(
            rate=self.rate,
            channels=channels,
            samples=samples,
            valid=valid,
            gaps=tuple(Gap(g.first - first, g.count, g.reason) for g in self._gaps(valid, first)),
            trigger=None if trigger is None else trigger - first,
            notes=(*self.notes, *self.contradictions, *notes),
        )

    def checksum_agrees(self) -> bool | None:
        """Whether the CRC-32 of all samples is the one in END; None while that cannot be known."""
        if self.end is None:
            return None
        check, at, count = 0, 0, 0
        for piece in sorted(self._pieces.values(), key=lambda p: p.data.first_index):
            data, known = piece.data, max(at - piece.data.first_index, 0)
            check = crc32(data.samples[known * data.channels * data.format.size :], check)
            count += max(data.n - known, 0)
            at = max(at, piece.stop)
        if count != self.end.total_samples - self.end.total_dropped:
            return None
        return check == self.end.checksum

    def board_clock(self) -> ClockFit | None:
        """The rate by the board's own times of its samples; None with too few."""
        pieces = self._pieces.values()
        return fit_clock([p.data.first_index for p in pieces], [p.data.board_time_us * 1e-6 for p in pieces])

    def host_clock(self) -> ClockFit | None:
        """The rate by the times at which samples reached the host before END; None with too few."""
        pieces = [p for p in self._pieces.values() if isfinite(p.time)]
        return fit_clock([p.stop for p in pieces], [p.time for p in pieces])

    def _forget_samples(self) -> None:
        """Begin at index 0: what came before belongs to an earlier capture."""
        self.end, self.window, self.rebooted = None, None, False
        self.expected, self.duplicates, self._missing, self._sequence = 0, 0, 0, -1
        for items in (self._pieces, self._overruns, self.events, self.contradictions):
            items.clear()

    def _take_hello(self, hello: Hello) -> tuple[Block | Gap, ...]:
        known = self.hello
        if known is None or not self._pieces:
            self.hello = hello
        elif hello.boot_id != known.boot_id and not self.rebooted:
            self.rebooted = True
            _list(self.notes, f"the board rebooted after sample {self.expected - 1}")
            return (Gap(self.expected, max(self.stop - self.expected, 0), "reboot"),)
        return ()

    def _take_description(self, description: Describe) -> None:
        problem = problem_of(description)
        if problem:
            _list(self.contradictions, problem)
        elif self._pieces and description != self.description:
            _list(self.contradictions, "the board described other channels in the middle of the recording")
        else:
            self.description = description

    def _take_event(self, event: Event) -> None:
        if len(self.events) < MAX_LISTED:
            self.events.append(event)
        if event.kind == EventKind.OVERRUN:
            self._overrun(event.index, event.index + event.count)

    def _take_data(self, sequence: int, data: Data, time: float) -> tuple[Block | Gap, ...]:
        if self.end is not None and not self._pieces and data.first_index + data.n > self._total():
            self.end = None  # a STOP asked twice is answered twice: this END was of the capture before
        problem = self._objection(data)
        if problem:
            _list(self.contradictions, problem)
        if problem or self.rebooted or data.n == 0:
            return ()
        again = self.end is not None
        if data.first_index < self.expected and not again:
            self._take_late(sequence, _Piece(data, time))
            return ()
        if data.dropped_before:
            self._overrun(data.first_index - data.dropped_before, data.first_index)
        lost = self._lost_before(data) if not again else ()
        self._sequence = sequence
        if not self._keep(_Piece(data, float("nan") if again else time)):
            return ()
        return (*lost, Block(data.first_index, self._convert(data), time))

    def _take_late(self, sequence: int, piece: _Piece) -> None:
        """A frame sent before the last one was delayed or doubled by the wire; a newer one contradicts it."""
        if 0 < (sequence - self._sequence) & 0xFFFFFFFF < 1 << 31:
            where = piece.data.first_index
            _list(self.contradictions, f"the sample index went back to {where} without a reboot")
        else:
            self._keep(piece)

    def _keep(self, piece: _Piece) -> bool:
        """Store a piece unless the one stored at that place is as long; return whether it is new."""
        known = self._pieces.get(piece.data.first_index)
        if known is not None and known.data.n >= piece.data.n:
            self.duplicates += 1
            return False
        self._pieces[piece.data.first_index] = piece
        self.expected = max(self.expected, piece.stop)
        return True

    def _objection(self, data: Data) -> str | None:
        if self.description is None:
            return "samples came before a description of the channels"
        if data.channels != len(self.description.channels):
            return f"samples of {data.channels} channels, but {len(self.description.channels)} were described"
        ahead = data.first_index - self.expected
        if ahead + self._missing > MAX_MISSING // data.channels:
            return f"the sample index jumped by {ahead} samples to {data.first_index}"
        if self.end is not None and data.first_index + data.n > max(self._total(), self.expected):
            return f"sample {data.first_index + data.n - 1} came after the board had said END"
        return None

    def _lost_before(self, data: Data) -> tuple[Gap, ...]:
        count = data.first_index - self.expected
        self._missing += count
        dropped = min(data.dropped_before, count)
        wire, overrun = count - dropped, dropped
        if self._reasons:
            return tuple(gap for gap in self._reasons if self.expected <= gap.first < data.first_index)
        lost = (Gap(self.expected, wire, "wire"), Gap(self.expected + wire, overrun, "overrun"))
        return tuple(gap for gap in lost if gap.count)

    def _overrun(self, first: int, stop: int) -> None:
        if len(self._overruns) < MAX_LISTED * 100:
            self._overruns.append((max(first, 0), stop))

    def _convert(self, data: Data) -> Array:
        assert self.description is not None
        numbers = np.frombuffer(data.samples, data.format.code).reshape(data.n, data.channels).T
        values = numbers.astype(np.float64)
        for row, channel in zip(values, self.description.channels, strict=True):
            if channel.scale != 1.0:
                row *= channel.scale
            if channel.offset != 0.0:
                row += channel.offset
        return values

    def _within(self, first: int, stop: int) -> list[_Piece]:
        return [p for p in self._pieces.values() if p.data.first_index < stop and p.stop > first]

    def _mask(self, first: int, stop: int) -> Mask:
        valid = np.zeros(max(stop - first, 0), dtype=np.bool_)
        for piece in self._within(first, stop):
            valid[max(piece.data.first_index - first, 0) : piece.stop - first] = True
        return valid

    def _gaps(self, valid: Mask, first: int) -> tuple[Gap, ...]:
        if valid.all():
            return ()
        reasons = np.full(len(valid), "wire", dtype=object)
        arrived = self._mask(first, first + len(valid))
        reasons[arrived] = "not a number"
        for a, b in self._overruns:
            part = slice(max(a - first, 0), max(b - first, 0))
            reasons[part][~arrived[part]] = "overrun"
        for gap in self._reasons:
            reasons[max(gap.first - first, 0) : max(gap.first + gap.count - first, 0)] = gap.reason
        if self.rebooted:
            reasons[max(self.expected - first, 0) :] = "reboot"
        reasons[valid] = None
        edges = np.flatnonzero(reasons[1:] != reasons[:-1]) + 1
        runs = zip([0, *edges.tolist()], [*edges.tolist(), len(valid)], strict=True)
        return tuple(Gap(first + a, b - a, reasons[a]) for a, b in runs if reasons[a] is not None)


def assemble(records: Iterable[Record]) -> Assembly:
    """Decode the records of a raw log, in order."""
    decoder, assembly = Decoder(), Assembly()
    for record in records:
        if record.kind is Kind.RECEIVED:
            for frame in decoder.feed(record.payload):
                assembly.take(frame, record.time)
        elif record.kind is Kind.NOTE:
            assembly.take_note(record.note())
    return assembly


def _list(items: list[str], text: str) -> None:
    if len(items) < MAX_LISTED and text not in items[-3:]:
        items.append(text)
