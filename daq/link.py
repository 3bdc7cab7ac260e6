"""The conversation with a board: frames taken as they come, and requests that are answered.

A thread reads, writes the bytes to the raw log, cuts them into frames and queues these. All else happens in the caller's
thread, in `take`, `request` and what builds on them. No wait is unbounded.
"""

import itertools
import queue
import threading
import time
from collections.abc import Callable
from typing import Self

from daq.decode import Assembly, Block, is_ours
from daq.errors import (
    BoardError,
    LinkLost,
    PortError,
    StationError,
)
from daq.plain_text import one_line
from daq.port import Port, may_have_reset_the_board
from daq.raw_log import Kind, RawLog
from daq.recording import Gap
from firmware_protocol import (
    PROTOCOL_MAJOR,
    PROTOCOL_MINOR,
    TYPE_OF,
    Ack,
    Config,
    Data,
    Decoder,
    Describe,
    Frame,
    Hello,
    HelloRequest,
    Message,
    Nack,
    NackCode,
    OtherVersion,
    Resend,
    Start,
    Statistics,
    Stop,
    TimeSync,
    encode,
)

BOOT_S = 3.0
HELLO_FOR_S, HELLO_EVERY_S = 5.0, 0.25
ANSWER_S = (0.25, 0.5, 1.0, 2.0)
END_S = 30.0
WARN_S = 0.5
ALIVE_S = 0.5
GIVE_UP_S = 2.0
NOISE_PIECES = 10
MOST_BYTES = 1 << 22


class FrameReader:
    """Frames from a port with the host's times of their arrival, in order; `close` ends the thread.

    Reading ends when the log has grown by `most_bytes`: what is still to be had then is refused in `take`.
    """

    def __init__(self, port: Port, log: RawLog) -> None:
        self.most_bytes = MOST_BYTES
        self._begun = log.size
        self._port = port
        self._log = log
        self.decoder = Decoder()
        self._queue: queue.SimpleQueue[tuple[float, Frame] | StationError] = queue.SimpleQueue()
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._read, name=f"reader of {port.name}", daemon=True)
        self._start()

    def _start(self) -> None:
        self._thread.start()

    def take(self, timeout: float) -> tuple[float, Frame] | None:
        """Return the next frame and its time (s); None when none came within `timeout` s.

        Raises LinkLost once everything that came before it was taken.
        """
        try:
            item = self._queue.get(timeout=timeout)
        except queue.Empty:
            return None
        if isinstance(item, StationError):
            self._queue.put(item)  # nothing comes after it, whoever asks again
            raise item
        return item

    def close(self) -> None:
        """Stop reading."""
        self._stopping.set()
        self._thread.join(timeout=2.0)

    def _read(self) -> None:
        try:
            while not self._stopping.is_set():
                self.read_once()
        except StationError as error:
            self._queue.put(error)
        except Exception as error:
            self._queue.put(LinkLost(f"{self._port.name} cannot be read any more ({error})"))

    def read_once(self) -> int:
        """Take what the port has, log it and queue its frames; return how many bytes it was."""
        data = self._port.read()
        if data:
            when = self._log.append(Kind.RECEIVED, data)
            for frame in self.decoder.feed(data):
                self._queue.put((when, frame))
            if self._log.size - self._begun > self.most_bytes:
                raise BoardError(
                    f"{self._port.name}: more than {self.most_bytes / 1e6:.0f} MB came, more than the request can"
                    " need; check baud rate and port, or the board's firmware"
                )
        return len(data)


class Link:
    """One board behind one port; its frames go through `assembly`, its bytes to `log`."""

    def __init__(self, port: Port, log: RawLog | None = None) -> None:
        self.port = port
        self.log = RawLog() if log is None else log
        self.assembly = Assembly()
        self.last_frame = time.monotonic()
        self.on_event: Callable[[Block | Gap], None] = lambda event: None
        self.keep_alive = False  # let the board hear this host twice a second, while `take` is called
        self._spoke = time.monotonic()
        self._sequence = 0
        self._reader = FrameReader(port, self.log)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *reason: object) -> None:
        self.close()

    def close(self) -> None:
        """Stop reading and give the port back."""
        self._reader.close()
        self.port.close()

    @property
    def statistics(self) -> Statistics:
        """What the decoder counted."""
        return self._reader.decoder.statistics

    def allow(self, log_bytes: int) -> None:
        """Let the log grow by so many bytes from its beginning; 4 MB are allowed before this."""
        self._reader.most_bytes = log_bytes

    def take(self, timeout: float) -> Frame | None:
        """Return the next frame, having passed it through the assembly; None when none came in time.

        Frames of another stream than the first are not returned.
        Raises LinkLost once everything that came before it was taken.
        """
        self.log.sync_if_due()
        if self.keep_alive and time.monotonic() - self._spoke >= ALIVE_S:
            self.send(TimeSync(time.monotonic_ns() // 1000))
        arrival = self._reader.take(timeout)
        if arrival is None:
            return None
        when, frame = arrival
        self.last_frame = time.monotonic()
        for event in self.assembly.take(frame, when):
            self.on_event(event)
        return frame if is_ours(frame) else None

    def silence(self) -> float:
        """Seconds since the last sound frame was taken."""
        return time.monotonic() - self.last_frame

    def send(self, message: Message, prefix: bytes = b"") -> int:
        """Send one message and return its frame's sequence."""
        sequence, self._sequence = self._sequence, self._sequence + 1
        data = prefix + encode(message, sequence)
        self._spoke = time.monotonic()
        self.log.append(Kind.SENT, data)
        self.port.write(data)
        return sequence

    def wait(self, is_it: Callable[[Message | OtherVersion], bool], seconds: float) -> Frame | None:
        """Take frames until one is what is waited for; None after that many seconds."""
        until = time.monotonic() + seconds
        while (left := until - time.monotonic()) > 0:
            frame = self.take(min(left, 0.1))
            if frame is not None and is_it(frame.message):
                return frame
        return None

    def handshake(self, seconds: float = HELLO_FOR_S) -> Hello:
        """Ask who is there until HELLO and DESCRIBE have come; stop a board that still samples.

        BoardError for another major version, or for a description that makes no sense,
        PortError when nothing answers in time.
        """
        self._let_a_boot_loader_pass()
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            self.send(HelloRequest(), prefix=b"\0")
            ask_again = min(time.monotonic() + HELLO_EVERY_S, until)
            while (left := ask_again - time.monotonic()) > 0:
                frame = self.take(left)
                hello = self._understand(frame.message) if frame is not None else None
                if hello is not None:
                    self.assembly.end = None  # that of this STOP is waited for
                    self.stop()
                    self.assembly.contradictions.clear()
                    return hello
        raise _no_answer(self.port.name, seconds, self.statistics, self.assembly.hello is not None)

    def _let_a_boot_loader_pass(self) -> None:
        """Say nothing to a board that may be booting until it has sent a frame, for BOOT_S at most.

        The boot loader of an Arduino Mega takes what it hears for a new program, and does not start the one that is
        there while bytes keep coming.
        """
        if may_have_reset_the_board(self.port) and not self.assembly.frames:
            self.wait(lambda message: True, BOOT_S)

    def _understand(self, message: Message | OtherVersion) -> Hello | None:
        """Return HELLO once both it and DESCRIBE are there."""
        if isinstance(message, OtherVersion):
            raise BoardError(_versions(f"{message.major}"))
        if isinstance(message, Hello) and message.major != PROTOCOL_MAJOR:
            raise BoardError(_versions(f"{message.major}.{message.minor}"))
        if isinstance(message, Describe) and self.assembly.description is None:
            raise BoardError(f"{self.assembly.contradictions[-1]}; its firmware needs a correction")
        described = self.assembly.description is not None
        return self.assembly.hello if described and isinstance(message, Hello | Describe) else None

    def request(self, message: Message, also: Callable[[Message | OtherVersion], bool] | None = None) -> None:
        """Send a request until it is answered by ACK, or by what is as good (`also`).

        BoardError on NACK or when the board sends other things, LinkLost when it fell silent.
        """
        sent: set[int] = set()

        def done(m: Message | OtherVersion) -> bool:
            return _answers(m, message, sent) or (also is not None and also(m))

        if not any(self._ask(message, sent, done, seconds) for seconds in ANSWER_S):
            raise _unanswered(self, message)

    def _ask(
        self, message: Message, sent: set[int], done: Callable[[Message | OtherVersion], bool], seconds: float
    ) -> bool:
        """Send a request once more and wait until it is `done`; False after so many seconds. BoardError on NACK."""
        sent.add(self.send(message))
        frame = self.wait(lambda m: done(m) or (isinstance(m, Nack) and _answers(m, message, sent)), seconds)
        if frame is not None and isinstance(frame.message, Nack) and _answers(frame.message, message, sent):
            raise _refused(message, frame.message)
        return frame is not None

    def configure(self, rate_hz: float) -> None:
        """Set the rate (0: the board's own) and learn from DESCRIBE what the board will really do."""
        self.request(Config(rate_hz=rate_hz))
        if self.wait(lambda message: isinstance(message, Describe), WARN_S) is None:
            self.handshake(GIVE_UP_S)
        if self.assembly.contradictions:
            raise BoardError(f"{self.assembly.contradictions[-1]}; its firmware needs a correction")

    def start(self) -> None:
        """Begin to sample at index 0."""
        self.log.note(event="start")
        self.assembly.take_note({"event": "start"})
        self.request(Start(), also=lambda message: isinstance(message, Data))
        self.last_frame = time.monotonic()

    def stop(self) -> None:
        """End sampling and wait for END; asked for again when it was lost.

        A slow line may first have to carry what the board had sampled: while samples come it is waited for,
        up to END_S. BoardError and LinkLost as in `request`.
        """
        until = time.monotonic() + END_S
        sent: set[int] = set()
        for seconds in itertools.chain(ANSWER_S, itertools.repeat(ANSWER_S[-1])):
            before = self.assembly.expected
            self._ask(Stop(), sent, lambda m: self.assembly.end is not None, seconds)
            if self.assembly.end is not None:
                return
            still = self.assembly.expected == before
            if self.silence() > GIVE_UP_S or time.monotonic() > until:
                break
            if still and len(sent) >= len(ANSWER_S):
                break
        raise _unanswered(self, Stop())

    def resend(self, first: int, count: int, until: float) -> bool | None:
        """Ask for samples again, after END; return whether the board holds them all, None when it did not say.

        Returns when it is answered, when no sample that was missing has come for 0.5 s, or at the time `until`.
        """
        message = Resend(first, count)
        sequence = self.send(message)
        received, since = self.assembly.samples.received, time.monotonic()
        while (now := time.monotonic()) < until and now - since < WARN_S:
            frame = self.take(0.05)
            if frame is not None and _answers(frame.message, message, {sequence}):
                return isinstance(frame.message, Ack)
            if self.assembly.samples.received > received:
                received, since = self.assembly.samples.received, time.monotonic()
        return None


def _answers(answer: Message | OtherVersion, request: Message, sequences: set[int]) -> bool:
    return (
        isinstance(answer, Ack | Nack)
        and answer.request_type == TYPE_OF[type(request)]
        and answer.request_sequence in sequences
    )


def _refused(request: Message, nack: Nack) -> StationError:
    what = type(request).__name__.upper()
    words = one_line(nack.text) or nack.code.name.replace("_", " ").lower()
    if nack.code == NackCode.UNSUPPORTED and isinstance(request, Config):
        return BoardError(f"the board cannot do {request.rate_hz:g} Hz: {words}; ask for another rate")
    return BoardError(f"the board refused {what}: {words}")


def _versions(theirs: str) -> str:
    return (
        f"the board speaks version {theirs} of the protocol, this station"
        f" {PROTOCOL_MAJOR}.{PROTOCOL_MINOR}; bring both to the same major version"
    )


def _no_answer(port: str, seconds: float, counts: Statistics, said_hello: bool) -> StationError:
    """Return the error for the handshake on `port` that `counts` tells of, after so many seconds.

    PortError where nothing of a board came, BoardError where frames came whole.
    """
    sound = counts.frames + counts.malformed + counts.unknown
    if not counts.bytes:
        return PortError(
            f"{port}: nothing answered within {seconds:g} s; is the board there and powered, and no other program using "
            "this port?"
        )
    if not sound:
        return PortError(
            f"{port}: {counts.bytes} bytes came within {seconds:g} s, but no answer of a board;"
            " check baud rate and port"
        )
    what = f"{sound} frames came whole within {seconds:g} s, and none was the HELLO that was asked for"
    if said_hello:
        what = "the board says HELLO and does not describe its channels"
    if counts.malformed:
        what += f"; {counts.malformed} frames are sound but not understood ({counts.why_malformed})"
    if counts.too_long:
        what += f"; {counts.too_long} were longer than a frame may be"
    return BoardError(f"{port}: {what}. The line is good, the firmware needs a correction")


def _unanswered(link: Link, request: Message) -> StationError:
    """Return the error for a request without an answer."""
    port, what, counts = link.port.name, type(request).__name__.upper(), link.statistics
    silent = link.silence() > WARN_S
    if silent and is_noisy(counts):
        return LinkLost(
            f"{port}: no answer to {what} came through the noise ({counts.damaged} damaged pieces so far);"
            " check cable, baud rate and what else speaks on this line"
        )
    if silent:
        return LinkLost(f"{port}: the board fell silent and did not answer {what}; reset it")
    return BoardError(f"{port}: the board does not answer {what}; its firmware needs a correction")


def is_noisy(counts: Statistics) -> bool:
    """Check whether more damaged pieces than sound frames came."""
    return counts.damaged > max(counts.frames, NOISE_PIECES)
