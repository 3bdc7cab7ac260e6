"""The board's firmware: requests in, frames out; it samples, keeps the newest samples, and answers.

It holds no port and reads no clock: the caller hands it bytes and the time. All of
`docs/protocol.md` from the board's side is here.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol
from zlib import crc32

import numpy as np

from firmware_protocol import (
    PROTOCOL_MAJOR,
    TYPE_OF,
    Ack,
    ChannelDescription,
    Config,
    Data,
    Decoder,
    Describe,
    End,
    Event,
    EventKind,
    Frame,
    Heartbeat,
    Hello,
    HelloRequest,
    Message,
    Nack,
    NackCode,
    OtherVersion,
    Resend,
    ResetCause,
    SampleFormat,
    Start,
    Stop,
    TimeSync,
    encode,
)
from mocks.lies import Lies

FORMATS: dict[SampleFormat, np.dtype[Any]] = {
    SampleFormat.I16: np.dtype("<i2"),
    SampleFormat.I32: np.dtype("<i4"),
    SampleFormat.F32: np.dtype("<f4"),
    SampleFormat.F64: np.dtype("<f8"),
}
RATES_HZ = (5.0, 20000.0)
ROOM_FOR_SAMPLES = 900  # Bytes of samples in a frame of 1024.
BUFFER_S = 2.0  # Unsent samples that fit before the board drops some.
HEARTBEAT_S = 0.5
SILENCE_S = 0.25
LONGEST_WAIT_S = 0.1


class Source(Protocol):
    """What the board samples."""

    def take(self, count: int) -> np.ndarray:
        """Return the next `count` samples, (count, channels) codes."""


@dataclass
class Settings:
    """What CONFIG sets."""

    rate: float = 256.0
    samples_per_frame: int = 16
    format: SampleFormat = SampleFormat.I16


@dataclass
class Capture:
    """One START to END: the counters, what waits to be sent and what is kept for RESEND."""

    source: Source
    count: int
    started: float
    started_us: int
    sampled: int = 0
    dropped: int = 0
    dropped_unsaid: int = 0
    checksum: int = 0
    waiting: deque[tuple[int, int, np.ndarray]] = field(default_factory=deque)
    kept: deque[tuple[int, np.ndarray]] = field(default_factory=deque)

    @property
    def unsent(self) -> int:
        """Samples that wait to be sent."""
        return sum(len(codes) for _, _, codes in self.waiting)


class Board:
    """The state machine. `speed` 0: as fast as the frames are taken, else times real time."""

    def __init__(
        self,
        channels: tuple[ChannelDescription, ...],
        source: Callable[[float], Source],
        random: np.random.Generator,
        now: float,
        speed: float = 1.0,
        lies: Lies | None = None,
        memory_s: float = 8.0,
    ) -> None:
        self._channels = channels
        self._source = source
        self._random = random
        self._speed = speed
        self._lies = lies or Lies()
        self._memory_s = memory_s
        self._settings = Settings()
        self._boot(now, ResetCause.POWER_ON)

    def _boot(self, now: float, cause: ResetCause) -> None:
        self._cause = cause
        self._boot_id = int(self._random.integers(1, 2**32))
        self._booted = now
        self._ahead_us = 0
        self._sequence = 0
        self._decoder = Decoder()
        self._capture: Capture | None = None
        self._sampling = False
        self._dropped_ever = 0
        self._last_end = End(0, 0, 0)
        self._out: list[bytes] = []
        self._spoke = now
        self._beat = now

    @property
    def sampled_s(self) -> float:
        """How much of the running capture has been sampled, s; 0 while idle."""
        if self._capture is None or not self._sampling:
            return 0.0
        return self._capture.sampled / self._settings.rate

    def reboot(self, now: float) -> None:
        """Start anew, as after a brownout: everything is forgotten, the boot_id is another."""
        self._settings = Settings()
        self._boot(now, ResetCause.BROWNOUT)

    def receive(self, data: bytes, now: float) -> None:
        """Take bytes from the host and prepare the answers."""
        for frame in self._decoder.feed(data):
            self._answer(frame, now)

    def poll(self, now: float, room: bool) -> list[bytes]:
        """Return the frames due at `now`; samples only while there is `room` on the way out."""
        if self._sampling and self._capture is not None:
            self._sample(self._capture, now, room)
            if room:
                self._send_full_frames(self._capture, now)
        quiet = SILENCE_S if self._sampling else HEARTBEAT_S
        since = self._spoke if self._sampling else self._beat
        if now - since >= quiet and not self._out:
            self._beat = now
            self._say(Heartbeat(self._uptime_us(now), self._fill(), self._dropped_ever))
        out, self._out = self._out, []
        if out:
            self._spoke = now
        return out

    def _say(self, message: Message) -> None:
        version = 2 if self._lies.wrong_version else PROTOCOL_MAJOR
        self._out.append(encode(message, self._sequence, version=version))
        self._sequence = (self._sequence + 1) & 0xFFFFFFFF

    def _uptime_us(self, now: float) -> int:
        pace = self._speed or 1.0
        return int((now - self._booted) * pace * self._lies.clock * 1e6) + self._ahead_us

    def _fill(self) -> int:
        if self._capture is None:
            return 0
        return min(100, int(100 * self._capture.unsent / self._most_unsent()))

    def _most_unsent(self) -> int:
        return max(64, int(BUFFER_S * self._settings.rate * max(1.0, self._speed)))

    def _answer(self, frame: Frame, now: float) -> None:
        message = frame.message
        if isinstance(message, OtherVersion):
            self._say(self._hello())
        elif isinstance(message, HelloRequest):
            self._say(self._hello())
            self._say(self._describe())
        elif isinstance(message, TimeSync):
            self._say(TimeSync(message.host_time_us, self._uptime_us(now)))
        elif isinstance(message, Stop):
            self._ack(frame)
            if self._sampling:
                self._finish(now)
            else:
                self._say(self._last_end)
        elif not isinstance(message, Config | Start | Resend):
            self._nack(frame, NackCode.NOT_UNDERSTOOD, "this message is not for a board")
        elif self._sampling:
            self._nack(frame, NackCode.BUSY, "the board is sampling; send STOP first")
        elif isinstance(message, Config):
            self._configure(frame, message)
        elif isinstance(message, Start):
            self._ack(frame)
            self._start(message, now)
        else:
            self._resend(frame, message)

    def _ack(self, frame: Frame) -> None:
        assert not isinstance(frame.message, OtherVersion)
        self._say(Ack(frame.sequence, TYPE_OF[type(frame.message)]))

    def _nack(self, frame: Frame, code: NackCode, text: str) -> None:
        assert not isinstance(frame.message, OtherVersion)
        self._say(Nack(frame.sequence, TYPE_OF[type(frame.message)], code, text))

    def _hello(self) -> Hello:
        return Hello(
            boot_id=self._boot_id,
            clock_hz=48_000_000,
            reset_cause=self._cause,
            major=2 if self._lies.wrong_version else PROTOCOL_MAJOR,
            firmware="bench double 1.0",
            board="Simulated bench board",
            unique_id="SIM-0001",
        )

    def _describe(self) -> Describe:
        form = self._settings.format
        whole = form in (SampleFormat.I16, SampleFormat.I32)
        channels = tuple(
            ChannelDescription(
                name=c.name,
                quantity=c.quantity,
                unit=c.unit,
                scale=c.scale if whole else 1.0,
                offset=c.offset if whole else 0.0,
                rate_hz=self._settings.rate,
                low=c.low,
                high=c.high,
                resolution=c.resolution,
                group_delay_s=c.group_delay_s,
                sensor=c.sensor,
            )
            for c in self._channels
        )
        return self._lies.description(Describe(form, channels))

    def _configure(self, frame: Frame, wanted: Config) -> None:
        rate = wanted.rate_hz or self._settings.rate
        form = wanted.format or self._settings.format
        most = ROOM_FOR_SAMPLES // (len(self._channels) * form.size)
        n = wanted.samples_per_frame or max(1, min(most, int(rate / 16.0)))
        if not RATES_HZ[0] <= rate <= RATES_HZ[1]:
            text = f"{rate:g} Hz asked for; this board samples at {RATES_HZ[0]:g} to {RATES_HZ[1]:g} Hz"
            return self._nack(frame, NackCode.UNSUPPORTED, text)
        if n > most:
            text = f"{n} samples a frame asked for; {most} of {form.name} fit"
            return self._nack(frame, NackCode.UNSUPPORTED, text)
        self._settings = Settings(rate, n, form)
        self._ack(frame)
        return self._say(self._describe())

    def _start(self, message: Start, now: float) -> None:
        true_rate = self._settings.rate * self._lies.rate
        self._capture = Capture(self._source(true_rate), message.count, now, self._uptime_us(now))
        self._sampling = True

    def _sample(self, capture: Capture, now: float, room: bool) -> None:
        """Take the samples that are due, or drop them when nothing has gone out for too long."""
        if self._speed:
            pace = self._speed * self._settings.rate * self._lies.rate
            due = int((now - capture.started) * pace) - capture.sampled
        else:
            due = self._settings.samples_per_frame - capture.unsent if room else 0
        if capture.count:
            due = min(due, capture.count - capture.sampled)
        if due > 0:
            self._take(capture, due)
        if capture.count and capture.sampled >= capture.count:
            self._finish(now)

    def _take(self, capture: Capture, due: int) -> None:
        codes = self._lies.codes(capture.source.take(due))
        self._warn_of_saturation(capture.sampled, codes)
        first = capture.sampled
        capture.sampled += due
        if not self._speed:
            self._ahead_us += int(due / self._settings.rate * 1e6)
        free = max(0, self._most_unsent() - capture.unsent)
        kept = codes[:free]
        if len(kept):
            first = self._lies.index(first)
            capture.waiting.append((first, capture.dropped_unsaid, kept))
            capture.dropped_unsaid = 0
            capture.kept.append((first, kept))
            self._forget(capture)
        lost = due - len(kept)
        if lost:
            if not capture.dropped_unsaid:
                self._say(
                    Event(EventKind.OVERRUN, capture.sampled - lost, lost, text="the host reads too slowly")
                )
            capture.dropped_unsaid += lost
            capture.dropped += lost
            self._dropped_ever += lost

    def _warn_of_saturation(self, first: int, codes: np.ndarray) -> None:
        for channel in range(codes.shape[1]):
            full = np.nonzero((codes[:, channel] >= 32767) | (codes[:, channel] <= -32768))[0]
            if len(full):
                index = first + int(full[0])
                self._say(Event(EventKind.SATURATION, index, len(full), channel, "converter at its end"))

    def _forget(self, capture: Capture) -> None:
        oldest = capture.sampled - int(self._memory_s * self._settings.rate)
        while capture.kept and capture.kept[0][0] + len(capture.kept[0][1]) <= oldest:
            capture.kept.popleft()

    def _send_full_frames(self, capture: Capture, now: float) -> None:
        """Send what fills frames; a part of one, too, once it has waited for a tenth of a second."""
        patience = max(1, int(LONGEST_WAIT_S * self._settings.rate))
        least = min(self._settings.samples_per_frame, patience)
        while capture.waiting and (capture.unsent >= least or capture.waiting[0][2].shape[0] >= least):
            self._send_frame(capture)

    def _send_frame(self, capture: Capture) -> None:
        """Send one frame of contiguous samples from the head of what waits."""
        first, dropped, codes = capture.waiting.popleft()
        size = self._settings.samples_per_frame
        parts = [codes[:size]]
        have = len(parts[0])
        if len(codes) > size:
            capture.waiting.appendleft((first + size, 0, codes[size:]))
        while have < size and capture.waiting:
            follows, gap, more = capture.waiting[0]
            if gap or follows != first + have:
                break
            capture.waiting.popleft()
            piece = more[: size - have]
            parts.append(piece)
            have += len(piece)
            if len(more) > len(piece):
                capture.waiting.appendleft((follows + len(piece), 0, more[len(piece) :]))
        data = self._data(capture, first, dropped, np.concatenate(parts))
        capture.checksum = crc32(data.samples, capture.checksum)
        self._say(data)

    def _data(self, capture: Capture, first: int, dropped: int, codes: np.ndarray) -> Data:
        form = self._settings.format
        numbers = codes.astype(float) if form in (SampleFormat.F32, SampleFormat.F64) else codes
        if form in (SampleFormat.F32, SampleFormat.F64):
            scales = [c.scale for c in self._channels]
            offsets = [c.offset for c in self._channels]
            numbers = codes * np.array(scales) + np.array(offsets)
        time_us = capture.started_us + int(first * 1e6 / (self._settings.rate * self._lies.told_rate))
        payload = np.ascontiguousarray(numbers.astype(FORMATS[form])).tobytes()
        return Data(first, time_us, dropped, len(codes), codes.shape[1], form, payload)

    def _finish(self, now: float) -> None:
        assert self._capture is not None
        while self._capture.waiting:
            self._send_frame(self._capture)
        self._last_end = self._lies.end(
            End(self._capture.sampled, self._capture.dropped, self._capture.checksum)
        )
        self._say(self._last_end)
        self._sampling = False
        self._beat = now

    def _resend(self, frame: Frame, wanted: Resend) -> None:
        sent = 0
        capture = self._capture
        if capture is not None:
            oldest = capture.sampled - int(self._memory_s * self._settings.rate)
            end = wanted.first + wanted.count
            for first, codes in capture.kept:
                a, b = max(wanted.first, first, oldest), min(end, first + len(codes))
                for at in range(a, b, self._settings.samples_per_frame):
                    piece = codes[at - first : min(at + self._settings.samples_per_frame, b) - first]
                    self._say(self._data(capture, at, 0, piece))
                    sent += len(piece)
        if sent == wanted.count:
            self._ack(frame)
        else:
            self._nack(frame, NackCode.NOT_HELD, f"{wanted.count - sent} of these samples are not held")
