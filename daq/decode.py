"""From messages to a recording: the one way used live, in a replay and when a session is read.

`Assembly` takes frames in the order of their arrival. The sample index is the time axis; the frames'
order, `dropped_before` and `boot_id` distinguish a frame lost on the wire from an overrun of the board
and from a board that rebooted. Nothing that arrives makes it raise: what contradicts the protocol is listed in
`contradictions`, and what a capture does about it is the capture's affair.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from daq.description_checks import IMPORTED, WINDOW, Window, channels_of, noted, problem_of
from daq.errors import DataLost
from daq.plain_text import in_one_line
from daq.raw_log import Kind, Record
from daq.recording import Array, Channel, Gap, Mask, Recording
from daq.sample_store import Losses, SampleStore
from firmware_protocol import (
    Clock,
    Data,
    Decoder,
    Describe,
    End,
    Event,
    EventKind,
    Frame,
    Hello,
    Holder,
    HolderState,
    Log,
    OtherVersion,
)

STREAM = 0
MAX_MISSING = 1 << 22
"""Numbers (samples times channels) that may be missing: 34 MB where the recording is made."""
MAX_LISTED = 200
BOARD, SOURCE, IMPORT = "board", "source", "import"  # who made the samples, as the station noted it
ORIGINS = {"imported": IMPORT, "source": SOURCE}
LEAST_PPM, MOST_PPM = 0.01, 1e5
"""An oven's crystal, and a tenth: no board has a better clock, nor states a worse."""


@dataclass(frozen=True, eq=False)
class Block:
    """Samples from `first` on in SI units, shape (channels, n)."""

    first: int
    samples: Array


class Assembly:
    """Puts messages together; `recording()` may be asked at any time for what is there so far."""

    def __init__(self) -> None:
        self.hello: Hello | None = None
        self.description: Describe | None = None
        self.end: End | None = None
        self.window: Window | None = None
        self.holder: Holder | None = None
        self.clock_ppm: float | None = None
        self.clock_claim = ""  # what the board states of its clock that cannot be
        self.frames, self.rebooted, self.origin = 0, False, BOARD
        self.notes: list[str] = []
        self.events: list[Event] = []
        self.contradictions: list[str] = []
        self.samples = SampleStore()
        self.losses = Losses()
        self.jumped = 0  # samples that were missing when a later one came
        self._sequence, self._started = -1, False

    def take(self, frame: Frame, time: float) -> tuple[Block | Gap, ...]:
        """Take one frame; return the samples it brought and, before them, what was found missing."""
        message = frame.message
        self.frames += 1
        if not is_ours(frame):
            _list(
                self.notes, f"the board also sends stream {frame.stream}; only stream {STREAM} was recorded"
            )
            return ()
        if isinstance(message, Data):
            return self._take_data(frame.sequence, message, time)
        take = _TAKERS.get(type(message))
        return (take(self, in_one_line(message)) if take is not None else None) or ()

    def take_note(self, note: dict[str, Any]) -> None:
        """Take what the station wrote down between the bytes; what is not understood is skipped."""
        self.origin = ORIGINS.get(str(note.get("event")), self.origin)
        if note.get("event") == "window":
            self.window = noted(WINDOW, note) or self.window
        elif note.get("event") == "start":
            self._forget_samples()
        elif note.get("event") == "imported" and (found := noted(IMPORTED, note)) is not None:
            self.losses.noted = [Gap(*gap) for gap in found.gaps]
            self.notes += found.notes

    @property
    def expected(self) -> int:
        """The sample after the newest that arrived."""
        return self.samples.expected

    @property
    def rate(self) -> float:
        """Samples per second, as described; 0 before it was."""
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
        """The sample after the last: of the window, as far as samples came or, by END or a reboot, are short."""
        if self.window is None:
            return max(self.expected, self.total)
        planned = self.window.first + self.window.count
        if self.rebooted:
            return min(planned, self.expected + self.most_missing)
        return min(planned, max(self.expected, self.total))

    @property
    def total(self) -> int:
        """How many samples the board says it took, if that is believable."""
        total = self.end.total_samples if self.end else 0
        return total if total - self.expected <= self.most_missing else 0

    @property
    def most_missing(self) -> int:
        """How many samples may be missing before the recording would ask for too much memory."""
        return MAX_MISSING // max(len(self.description.channels) if self.description else 1, 1)

    def missing(self) -> tuple[Gap, ...]:
        """List the gaps of the recording so far, with reasons."""
        return self._gaps(self.samples.mask(self.start, self.stop), self.start)

    def between(self, first: int, stop: int) -> Array:
        """Return samples `first` to `stop - 1` in SI units, shape (channels, n); NaN where none arrived."""
        assert self.description is not None
        samples = np.full((len(self.description.channels), stop - first), np.nan)
        known = _convert(self.samples.bytes_of(first, stop), self.description)
        samples[:, : known.shape[1]] = known
        samples[:, ~self.samples.mask(first, stop)] = np.nan
        return samples

    def recording(self) -> Recording:
        """Return the recording; lost samples are NaN and not `valid`. DataLost when there are none at all."""
        channels, first, stop = self.channels, self.start, self.stop
        if not self.samples.received or self.description is None or stop <= first:
            raise DataLost("no sample was received, so there is nothing to read")
        samples = self.between(first, stop)
        valid: Mask = np.all(np.isfinite(samples), axis=0)
        samples[:, ~valid] = np.nan
        trigger = self.window.trigger if self.window else None
        return Recording(
            rate=self.rate,
            channels=channels,
            samples=samples,
            valid=valid,
            gaps=tuple(Gap(g.first - first, g.count, g.reason) for g in self._gaps(valid, first)),
            trigger=None if trigger is None else trigger - first,
            notes=(*self.notes, *self.contradictions),
        )

    def _forget_samples(self) -> None:
        """Begin at index 0: what came before belongs to an earlier capture."""
        self.end, self.window, self.rebooted = None, None, False
        self.samples = SampleStore()
        self.jumped, self._sequence, self._started = 0, -1, True
        for items in (self.losses, self.events, self.contradictions):
            items.clear()

    def _take_hello(self, hello: Hello) -> tuple[Gap, ...]:
        known = self.hello
        if known is None or not self.samples.received:
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
        elif (self.samples.received or self._started) and description != self.description:
            _list(self.contradictions, "the board described other channels in the middle of the recording")
        else:
            self.description = description

    def _take_clock(self, clock: Clock) -> None:
        """Believe what a clock can be; 0 says that the board does not know."""
        ppm = clock.error_ppm
        believed = LEAST_PPM <= ppm <= MOST_PPM
        self.clock_ppm = ppm if believed else None
        claim = f"the board states that its clock is off by at most {ppm:.3g} ppm, which is not believed"
        self.clock_claim = "" if believed or ppm == 0 else claim

    def _take_holder(self, holder: Holder) -> None:
        before, self.holder = self.holder, holder
        if before is not None and before.state is HolderState.HELD and holder.state is HolderState.FREE:
            _list(self.notes, f"the rig let go from {1e3 * before.displacement:g} mm")

    def _take_end(self, end: End) -> None:
        if self.end is not None and self.samples.received and end != self.end:
            _list(self.contradictions, "the board said END twice, with other numbers")
        else:
            self.end = end

    def _take_event(self, event: Event) -> None:
        if len(self.events) < MAX_LISTED:
            self.events.append(event)
        if event.kind == EventKind.OVERRUN:
            self.losses.overrun(event.index, event.index + event.count)
        if event.kind == EventKind.OTHER and event.text:
            _list(self.notes, f"the board reports: {event.text}")

    def _take_log(self, log: Log) -> None:
        _list(self.notes, f"the board said: {log.text}")

    def _take_data(self, sequence: int, data: Data, time: float) -> tuple[Block | Gap, ...]:
        if self.end is not None and not self.samples.received and data.first_index + data.n > self.total:
            self.end = None  # a STOP asked twice is answered twice: this END was of the capture before
        problem = _objection(self, data)
        if problem:
            _list(self.contradictions, problem)
        if problem or self.rebooted or data.n == 0:
            return ()
        again = self.end is not None
        if data.first_index < self.expected and not again:
            self._take_late(sequence, data, time)
            return ()
        if data.dropped_before and not again:
            self.losses.overrun(data.first_index - data.dropped_before, data.first_index)
            self.losses.dropped += data.dropped_before
        lost: tuple[Gap, ...] = ()
        if not again:
            self.jumped += data.first_index - self.expected
            lost = self.losses.before(data.first_index, self.expected, data.dropped_before)
        self._sequence = sequence
        new = self.samples.add(data, float("nan") if again else time)
        assert self.description is not None
        samples = _convert(data.samples, self.description)
        return (*lost, *(Block(data.first_index + a, samples[:, a:b]) for a, b in new))

    def _take_late(self, sequence: int, data: Data, time: float) -> None:
        """A frame sent before the last one was delayed or doubled by the wire; a newer one contradicts it."""
        if 0 < (sequence - self._sequence) & 0xFFFFFFFF < 1 << 31:
            _list(self.contradictions, f"the sample index went back to {data.first_index} without a reboot")
        else:
            self.samples.add(data, time)

    def _gaps(self, valid: Mask, first: int) -> tuple[Gap, ...]:
        arrived = self.samples.mask(first, first + len(valid))
        return self.losses.gaps(valid, arrived, first, self.expected if self.rebooted else None)


_TAKERS: dict[type, Callable[[Assembly, Any], tuple[Gap, ...] | None]] = {
    Hello: Assembly._take_hello, Describe: Assembly._take_description, Clock: Assembly._take_clock,
    Holder: Assembly._take_holder, End: Assembly._take_end, Event: Assembly._take_event, Log: Assembly._take_log,
}  # fmt: skip


def is_ours(frame: Frame) -> bool:
    """Check whether a frame belongs to the stream that is recorded; of another version nobody knows the stream."""
    return frame.stream == STREAM or isinstance(frame.message, OtherVersion)


def _objection(assembly: Assembly, data: Data) -> str | None:
    """Say how DATA contradicts an earlier statement of the board, or None."""
    description, end, expected = assembly.description, assembly.end, assembly.expected
    if description is None:
        return "samples came before a description of the channels"
    if data.channels != len(description.channels):
        return f"samples of {data.channels} channels, but {len(description.channels)} were described"
    if data.format != description.format:
        return f"samples in {data.format.name}, but {description.format.name} was described"
    ahead = data.first_index - expected
    if ahead + assembly.jumped > assembly.most_missing:
        return f"the sample index jumped by {ahead} samples to {data.first_index}"
    if end is None and data.dropped_before > ahead >= 0:
        return (
            f"DATA says that {data.dropped_before} samples were dropped before sample {data.first_index}, but only"
            f" {ahead} are missing there"
        )
    if end is not None and data.first_index + data.n > max(assembly.total, expected):
        return f"sample {data.first_index + data.n - 1} came after the board had said END"
    return None


@np.errstate(over="ignore", invalid="ignore")  # numbers of a board may be anything
def _convert(samples: bytes, description: Describe) -> Array:
    """Return samples in SI units, shape (channels, n)."""
    numbers = np.frombuffer(samples, description.format.code).reshape(-1, len(description.channels))
    values = numbers.T.astype(np.float64)
    for row, channel in zip(values, description.channels, strict=True):
        if channel.scale != 1.0:
            row *= channel.scale
        if channel.offset != 0.0:
            row += channel.offset
    return values


def play(records: Iterable[Record], assembly: Assembly) -> Iterator[tuple[Record, tuple[Block | Gap, ...]]]:
    """Pass the records of a raw log through an assembly, in order; yield each with what it brought."""
    decoder = Decoder()
    for record in records:
        if record.kind is Kind.NOTE:
            assembly.take_note(record.note())
        frames = decoder.feed(record.payload) if record.kind is Kind.RECEIVED else ()
        yield record, tuple(event for frame in frames for event in assembly.take(frame, record.time))


def assemble(records: Iterable[Record]) -> Assembly:
    """Decode the records of a raw log, in order."""
    assembly = Assembly()
    for _ in play(records, assembly):
        pass
    return assembly


def _list(items: list[str], text: str) -> None:
    if len(items) < MAX_LISTED and text not in items[-3:]:
        items.append(text)
