"""From messages to a recording: the one way used live, in a replay and when a session is read.

`Assembly` takes frames in the order of their arrival. The sample index is the time axis; the frames'
order, `dropped_before` and `boot_id` distinguish a frame lost on the wire from an overrun of the board
and from a board that rebooted. Nothing that arrives makes it raise: what contradicts the protocol is listed in
`contradictions`, and what a capture does about it is the capture's affair.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from daq.description_checks import Window, channels_of, gap_of, items_of, problem_of, window_of
from daq.errors import DataLost
from daq.losses import Losses
from daq.raw_log import Kind, Record
from daq.recording import Array, Channel, Gap, Mask, Recording
from daq.sample_store import Piece, SampleStore
from firmware_protocol import Data, Decoder, Describe, End, Event, EventKind, Frame, Hello, Log

MAX_MISSING = 1 << 22
MAX_LISTED = 200


@dataclass(frozen=True, eq=False)
class Block:
    """Samples from `first` on in SI units, shape (channels, n), that reached the host at `time`."""

    first: int
    samples: Array
    time: float


class Assembly:
    """Puts messages together; `recording()` may be asked at any time for what is there so far."""

    def __init__(self) -> None:
        self.hello: Hello | None = None
        self.description: Describe | None = None
        self.end: End | None = None
        self.window: Window | None = None
        self.rebooted = False
        self.frames = 0
        self.notes: list[str] = []
        self.events: list[Event] = []
        self.contradictions: list[str] = []
        self.samples = SampleStore()
        self._losses = Losses()
        self._missing, self._sequence = 0, -1

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
            self._losses.noted = [gap for item in items_of(note, "gaps") if (gap := gap_of(item)) is not None]
            self.notes += [item for item in items_of(note, "notes") if isinstance(item, str)]

    @property
    def expected(self) -> int:
        """The sample after the newest that arrived."""
        return self.samples.expected

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
        return self.window.first if self.window is not None else self.samples.first

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
        return self._gaps(self.samples.mask(self.start, self.stop), self.start)

    def recording(self, notes: Iterable[str] = ()) -> Recording:
        """Return the recording; lost samples are NaN and not `valid`. DataLost when there are none at all."""
        channels, first, stop = self.channels, self.start, self.stop
        if not self.samples or self.description is None or stop <= first:
            raise DataLost("no sample was received, so there is nothing to read")
        samples = np.full((len(channels), stop - first), np.nan)
        for piece in self.samples.within(first, stop):
            at = piece.data.first_index - first
            block = _convert(piece.data, self.description)[:, max(-at, 0) : stop - first - at]
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
        count, check = self.samples.checksum()
        if count != self.end.total_samples - self.end.total_dropped:
            return None
        return check == self.end.checksum

    def _forget_samples(self) -> None:
        """Begin at index 0: what came before belongs to an earlier capture."""
        self.end, self.window, self.rebooted = None, None, False
        self.samples = SampleStore()
        self._missing, self._sequence = 0, -1
        for items in (self._losses, self.events, self.contradictions):
            items.clear()

    def _take_hello(self, hello: Hello) -> tuple[Block | Gap, ...]:
        known = self.hello
        if known is None or not self.samples:
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
        elif self.samples and description != self.description:
            _list(self.contradictions, "the board described other channels in the middle of the recording")
        else:
            self.description = description

    def _take_event(self, event: Event) -> None:
        if len(self.events) < MAX_LISTED:
            self.events.append(event)
        if event.kind == EventKind.OVERRUN:
            self._losses.overrun(event.index, event.index + event.count)
        if event.kind == EventKind.OTHER and event.text:
            _list(self.notes, f"the board reports: {event.text}")

    def _take_data(self, sequence: int, data: Data, time: float) -> tuple[Block | Gap, ...]:
        if self.end is not None and not self.samples and data.first_index + data.n > self._total():
            self.end = None  # a STOP asked twice is answered twice: this END was of the capture before
        problem = self._objection(data)
        if problem:
            _list(self.contradictions, problem)
        if problem or self.rebooted or data.n == 0:
            return ()
        again = self.end is not None
        if data.first_index < self.expected and not again:
            self._take_late(sequence, Piece(data, time))
            return ()
        if data.dropped_before:
            self._losses.overrun(data.first_index - data.dropped_before, data.first_index)
        lost: tuple[Gap, ...] = ()
        if not again:
            self._missing += data.first_index - self.expected
            lost = self._losses.before(data.first_index, self.expected, data.dropped_before)
        self._sequence = sequence
        if not self.samples.add(Piece(data, float("nan") if again else time)):
            return ()
        assert self.description is not None
        return (*lost, Block(data.first_index, _convert(data, self.description), time))

    def _take_late(self, sequence: int, piece: Piece) -> None:
        """A frame sent before the last one was delayed or doubled by the wire; a newer one contradicts it."""
        if 0 < (sequence - self._sequence) & 0xFFFFFFFF < 1 << 31:
            where = piece.data.first_index
            _list(self.contradictions, f"the sample index went back to {where} without a reboot")
        else:
            self.samples.add(piece)

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

    def _gaps(self, valid: Mask, first: int) -> tuple[Gap, ...]:
        arrived = self.samples.mask(first, first + len(valid))
        return self._losses.gaps(valid, arrived, first, self.expected if self.rebooted else None)


def _convert(data: Data, description: Describe) -> Array:
    """Return samples in SI units, shape (channels, n)."""
    numbers = np.frombuffer(data.samples, data.format.code).reshape(data.n, data.channels).T
    values = numbers.astype(np.float64)
    for row, channel in zip(values, description.channels, strict=True):
        if channel.scale != 1.0:
            row *= channel.scale
        if channel.offset != 0.0:
            row += channel.offset
    return values


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
