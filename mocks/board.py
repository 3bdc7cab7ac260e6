"""The board's firmware: requests in, frames out; it samples, keeps the newest samples, and answers.

It holds no port and reads no clock: the caller hands it bytes and the time. All of
`docs/protocol.md` from the board's side is here.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from firmware_protocol import (
    PROTOCOL_MAJOR,
    TYPE_OF,
    Ack,
    ChannelDescription,
    Clock,
    Config,
    Data,
    Decoder,
    Describe,
    End,
    Frame,
    Heartbeat,
    Hello,
    HelloRequest,
    Hold,
    HolderReason,
    HolderState,
    Log,
    Message,
    Nack,
    NackCode,
    OtherVersion,
    Release,
    Resend,
    ResetCause,
    SampleFormat,
    Start,
    Stop,
    TimeSync,
    encode,
)
from mocks.capture import Capture, Settings, Source
from mocks.holder import Holder
from mocks.holding import Holding
from mocks.misconfigurations import Misconfiguration

RATES_HZ = (5.0, 20000.0)
ROOM_FOR_SAMPLES = 900  # Bytes of samples in a frame of 1024.
HEARTBEAT_S = 0.5
SILENCE_S = 0.25
MOST_AT_ONCE_S = 0.25
CATCHES_UP_S = 0.02
"""Seconds of samples at once, and for each unit of speed: a busy computer's double must not leap over a fault's time."""


class Board:
    """The state machine. `speed` 0: as fast as the frames are taken, else times real time."""

    def __init__(
        self,
        channels: tuple[ChannelDescription, ...],
        source: Callable[[float], Source],
        random: np.random.Generator,
        now: float,
        speed: float = 1.0,
        misconfiguration: Misconfiguration | None = None,
        memory_s: float = 12.0,
        holder: Holder | None = None,
    ) -> None:
        self._channels = channels
        self._source = source
        self._random = random
        self._speed = speed
        self._misconfiguration = misconfiguration or Misconfiguration()
        self._memory_s = memory_s
        self._holder = holder
        self._idle = (0.0, now)
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
        self._started = now
        self._dropped_ever = 0
        self._last_end = End(0, 0, 0)
        self._endless: Data | None = None
        self._out: list[bytes] = []
        self._spoke = now
        self._beat = now
        self._holding = None if self._holder is None else Holding(self._holder, self._boot_id, now)

    @property
    def sampled_s(self) -> float:
        """How much of the running capture has been sampled, s; 0 while idle."""
        if self._capture is None or not self._sampling:
            return 0.0
        return self._capture.sampled / self._capture.settings.rate

    def reboot(self, now: float) -> None:
        """Start anew, as after a brownout: everything is forgotten, the boot_id is another.

        A magnet without current lets go.
        """
        at = self._holder_s(now)
        if self._holding is not None and self._holding.state is not HolderState.FREE:
            self._holding.holder.let_go(at)
        self._idle = (at, now)
        self._settings = Settings()
        self._boot(now, ResetCause.BROWNOUT)

    def receive(self, data: bytes, now: float) -> None:
        """Take bytes from the host and prepare the answers."""
        for frame in self._decoder.feed(data):
            self._answer(frame, now)

    def hang_up(self, now: float) -> None:
        """Note that the line is closed at the host's end, as a board with USB of its own sees it."""
        if self._holding is not None:
            self._holding.let_go_slowly(HolderReason.SILENCE, self._holder_s(now))

    def contact(self, is_open: bool, now: float) -> None:
        """Open or close the stop contact."""
        if self._holding is not None:
            self._holding.contact(is_open, self._holder_s(now))

    def _holder_s(self, now: float) -> float:
        """The holder's clock: by the samples while there are any, else by the caller's."""
        if self._sampling and self._capture is not None and self._holder is not None:
            rate = self._settings.rate * self._misconfiguration.rate
            return self._holder.origin + self._capture.sampled / rate
        at, since = self._idle
        return at + (now - since) * (self._speed or 1.0)

    def poll(self, now: float, room: bool) -> list[bytes]:
        """Return the frames due at `now`; samples only while there is `room` on the way out."""
        if self._sampling and self._capture is not None:
            self._sample(self._capture, now, room)
        if self._endless is not None and room:
            self._say(self._endless)
        if self._holding is not None:
            for report in self._holding.poll(now, self._holder_s(now)):
                self._say(report)
        quiet = SILENCE_S if self._sampling else HEARTBEAT_S
        since = self._spoke if self._sampling else self._beat
        if now - since >= quiet and not self._out:
            self._beat = now
            fill = self._capture.fill_percent if self._capture else 0
            self._say(Heartbeat(self._uptime_us(now), fill, self._dropped_ever))
        out, self._out = self._out, []
        if out:
            self._spoke = now
        return out

    def _say(self, message: Message, stream: int = 0) -> None:
        version = 2 if self._misconfiguration.wrong_version else PROTOCOL_MAJOR
        self._out.append(encode(message, self._sequence, stream, version=version))
        self._sequence = (self._sequence + 1) & 0xFFFFFFFF
        if self._misconfiguration.second_stream and not stream:
            second = self._misconfiguration.second(message)
            if second is not None:
                self._say(second, stream=1)

    def _uptime_us(self, now: float) -> int:
        pace = self._speed or 1.0
        return int((now - self._booted) * pace * self._misconfiguration.clock * 1e6) + self._ahead_us

    def _answer(self, frame: Frame, now: float) -> None:
        message = frame.message
        if self._holding is not None:
            self._holding.hear(frame, now)
        if isinstance(message, OtherVersion):
            self._say(_hello(self._boot_id, self._cause, self._misconfiguration.wrong_version))
        elif isinstance(message, HelloRequest):
            self._say(_hello(self._boot_id, self._cause, self._misconfiguration.wrong_version))
            if not self._misconfiguration.silent:
                self._say_description()
            if self._misconfiguration.forged:
                self._say(Log("good\nverdict: OK"))
        elif isinstance(message, TimeSync):
            self._say(TimeSync(message.host_time_us, self._uptime_us(now)))
        elif isinstance(message, Stop):
            self._ack(frame)
            if self._holding is not None:
                self._holding.let_go_slowly(HolderReason.STOP, self._holder_s(now))
            if self._sampling:
                self._finish(now)
            else:
                self._say(self._last_end)
        elif isinstance(message, Hold | Release):
            self._hold(frame, message, now)
        elif not isinstance(message, Config | Start | Resend):
            return  # What a board says, given back by a line that echoes.
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

    def _say_description(self) -> None:
        self._say(self._describe())
        if self._misconfiguration.clock_says is not None:
            self._say(Clock(self._misconfiguration.clock_says))
        if self._holding is not None:
            self._say(self._holding.report())

    def _hold(self, frame: Frame, request: Hold | Release, now: float) -> None:
        if self._holding is None:
            return self._nack(frame, NackCode.NOT_UNDERSTOOD, "")
        refusal = self._holding.answer(request, self._holder_s(now))
        return self._nack(frame, *refusal) if refusal else self._ack(frame)

    def _describe(self) -> Describe:
        channels = _described(self._channels, self._settings)
        return self._misconfiguration.description(Describe(self._settings.format, channels))

    def _configure(self, frame: Frame, wanted: Config) -> None:
        rate = wanted.rate_hz or self._settings.rate
        form = wanted.format or self._settings.format
        most = ROOM_FOR_SAMPLES // (len(self._channels) * form.size)
        frame_s = self._misconfiguration.frame_s or 1.0 / 16.0
        n = wanted.samples_per_frame or max(1, min(most, int(rate * frame_s)))
        if not RATES_HZ[0] <= rate <= RATES_HZ[1]:
            text = f"{rate:g} Hz asked for; this board samples at {RATES_HZ[0]:g} to {RATES_HZ[1]:g} Hz"
            return self._nack(frame, NackCode.UNSUPPORTED, text)
        if n > most:
            text = f"{n} samples a frame asked for; {most} of {form.name} fit"
            return self._nack(frame, NackCode.UNSUPPORTED, text)
        self._settings = Settings(rate, n, form)
        self._ack(frame)
        return self._say_description()

    def _start(self, message: Start, now: float) -> None:
        if self._holder is not None and self._holding is not None:
            self._holder.begin(self._holder_s(now))
            self._holding.rate = self._settings.rate
        source = self._source(self._settings.rate * self._misconfiguration.rate)
        self._capture = Capture(
            source,
            self._settings,
            self._channels,
            self._misconfiguration,
            self._uptime_us(now),
            message.count,
            self._memory_s,
            self._speed,
        )
        self._started = now
        self._sampling = True

    def _sample(self, capture: Capture, now: float, room: bool) -> None:
        """Take the samples that are due; send them while there is room on the way out."""
        if self._speed:
            rate = self._settings.rate * self._misconfiguration.rate
            most = int(self._settings.rate * max(MOST_AT_ONCE_S, CATCHES_UP_S * self._speed)) + 1
            taken = self._misconfiguration.taken((now - self._started) * self._speed, rate)
            due = min(taken - capture.sampled, most)
        else:
            due = self._settings.samples_per_frame - capture.unsent if room else 0
        before = (capture.sampled, capture.dropped)
        for event in capture.take(due):
            self._say(event)
        self._dropped_ever += capture.dropped - before[1]
        if not self._speed:
            self._ahead_us += int((capture.sampled - before[0]) / self._settings.rate * 1e6)
        while room and (data := capture.next_data(last=False)) is not None:
            self._say(data)
        if capture.complete:
            self._finish(now)

    def _finish(self, now: float) -> None:
        assert self._capture is not None
        while (data := self._capture.next_data(last=True)) is not None:
            self._say(data)
        self._last_end = self._capture.end()
        self._say(self._last_end)
        self._idle = (self._holder_s(now), now)
        self._sampling = False
        if self._holder is not None and not self._speed:
            self._holder.rest(self._idle[0])
        self._beat = now

    def _resend(self, frame: Frame, wanted: Resend) -> None:
        if self._endless is not None:
            return
        sent = 0
        for data in self._capture.again(wanted.first, wanted.count) if self._capture else ():
            self._say(data)
            sent += data.n if data.first_index >= wanted.first else 0
            if self._misconfiguration.endless:
                self._endless = data
                return
        if sent == wanted.count:
            self._ack(frame)
        else:
            self._nack(frame, NackCode.NOT_HELD, f"{wanted.count - sent} of these samples are not held")


def _hello(boot_id: int, cause: ResetCause, wrong_version: bool) -> Hello:
    return Hello(
        boot_id=boot_id,
        clock_hz=48_000_000,
        reset_cause=cause,
        major=2 if wrong_version else PROTOCOL_MAJOR,
        firmware="bench double 1.0",
        board="Simulated bench board",
        unique_id="SIM-0001",
    )


def _described(
    channels: tuple[ChannelDescription, ...], settings: Settings
) -> tuple[ChannelDescription, ...]:
    """Return the channels at the rate and format set: floating-point samples are in SI units already."""
    whole = settings.format in (SampleFormat.I16, SampleFormat.I32)
    return tuple(
        dataclasses.replace(
            channel,
            rate_hz=settings.rate,
            scale=channel.scale if whole else 1.0,
            offset=channel.offset if whole else 0.0,
        )
        for channel in channels
    )
