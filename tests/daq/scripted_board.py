"""A board in the test's own process: it speaks the protocol on a scripted port and streams a closed form."""

import threading
import time
from collections.abc import Callable
from zlib import crc32

import numpy as np

from daq.errors import LinkLost
from firmware_protocol import (
    TYPE_OF,
    Ack,
    ChannelDescription,
    Config,
    Data,
    Decoder,
    Describe,
    End,
    Heartbeat,
    Hello,
    HelloRequest,
    Nack,
    NackCode,
    Resend,
    SampleFormat,
    Start,
    Stop,
    encode,
)

RATE = 256.0
RELEASE = 700
AMPLITUDE = 0.02
OMEGA = 24.8
DECAY = 0.14
NOISE_X, NOISE_A = 5e-6, 0.01


def decay(n: int = 6000, release: float = RELEASE, seed: int = 1) -> np.ndarray:
    """Displacement (m) and acceleration (m/s^2) of a viscous free decay held until `release`, shape (2, n)."""
    time_s = (np.arange(n) - release) / RATE
    free = time_s > 0
    envelope = AMPLITUDE * np.exp(-DECAY * np.where(free, time_s, 0))
    phase = np.where(free, OMEGA * time_s, 0)
    x = envelope * (np.cos(phase) + DECAY / OMEGA * np.sin(phase))
    v_rate = -AMPLITUDE * (OMEGA + DECAY**2 / OMEGA)
    a = np.where(
        free,
        v_rate * np.exp(-DECAY * np.where(free, time_s, 0)) * (OMEGA * np.cos(phase) - DECAY * np.sin(phase)),
        0.0,
    )
    noise = np.random.default_rng(seed).normal(size=(2, n)) * np.array([[NOISE_X], [NOISE_A]])
    return np.array([x, a]) + noise


def describe(rate: float = RATE) -> Describe:
    return Describe(
        SampleFormat.F64,
        (
            ChannelDescription("x", "displacement", "m", 1.0, 0.0, rate, -0.05, 0.05, 1e-6),
            ChannelDescription("a", "acceleration", "m/s^2", 1.0, 0.0, rate, -50.0, 50.0, 1e-3),
        ),
    )


class ScriptedBoard:
    """A Port. `mangle(first_index, frame)` may change or drop what the board streams; the script below it.

    `real_time` False streams as fast as it is read, up to `hurry` samples a second.
    """

    name = "scripted"

    def __init__(self, samples: np.ndarray, hurry: float = 16384.0, per_frame: int = 16) -> None:
        self.samples = samples
        self.description = describe()
        self.hello = Hello(boot_id=7, clock_hz=1_000_000, board="scripted")
        self.mangle: Callable[[int, bytes], bytes] = lambda first, frame: frame
        self.silent_from: int | None = None
        self.unplugged_at: int | None = None
        self.reboots_at: int | None = None
        self.held = samples.shape[1]
        self.dropped: set[int] = set()
        self.refuse: dict[type, Nack] = {}
        self.ignore: list[type] = []
        self._hurry, self._per_frame = hurry, per_frame
        self._decoder = Decoder()
        self._out = bytearray()
        self._lock = threading.Lock()
        self._sequence = 0
        self.sent = 0
        self.at_most = samples.shape[1]  # samples in one read
        self._dropped_before = 0
        self._started: float | None = None
        self.closed = False

    def write(self, data: bytes) -> None:
        with self._lock:
            for frame in self._decoder.feed(data):
                self._answer(frame.sequence, frame.message)

    def read(self) -> bytes:
        time.sleep(0.002)
        with self._lock:
            self._stream()
            data, self._out = bytes(self._out), bytearray()
        return data

    def close(self) -> None:
        self.closed = True

    def _send(self, message: object) -> None:
        self._out += encode(message, self._sequence)  # type: ignore[arg-type]
        self._sequence += 1

    def _answer(self, sequence: int, request: object) -> None:
        if type(request) in self.ignore:
            self.ignore.remove(type(request))
            return
        if self._is_silent() and not isinstance(request, HelloRequest):
            return
        if type(request) in self.refuse:
            nack = self.refuse[type(request)]
            self._send(Nack(sequence, TYPE_OF[type(request)], nack.code, nack.text))
            return
        if isinstance(request, HelloRequest):
            if not (self._is_silent() and self.reboots_at is None):
                self._send(self.hello)
                self._send(self.description)
            return
        if isinstance(request, Resend):
            self._resend(sequence, request)
            return
        self._send(Ack(sequence, TYPE_OF[type(request)]))
        if isinstance(request, Config):
            self._send(self.description)
        if isinstance(request, Start):
            self._started, self.sent = time.monotonic(), 0
        if isinstance(request, Stop):
            self._started = None
            self._end()

    def _is_silent(self) -> bool:
        return self.silent_from is not None and self.sent >= self.silent_from

    def _data(self, first: int, n: int, dropped: int = 0) -> Data:
        part = self.samples[:, first : first + n].T.astype("<f8").tobytes()
        return Data(first, round(first / RATE * 1e6), dropped, n, 2, SampleFormat.F64, part)

    def _stream(self) -> None:
        if self._started is None:
            return
        due = int((time.monotonic() - self._started) * self._hurry)

        due = min(due, self.sent + self.at_most, self.samples.shape[1])
        while self.sent + self._per_frame <= due:
            first = self.sent
            if self.unplugged_at is not None and first >= self.unplugged_at:
                if self._out:  # what left the board before the cable did arrives
                    return
                raise LinkLost("scripted went away; check cable and board")
            if self.reboots_at is not None and first >= self.reboots_at:
                self.hello = Hello(boot_id=8, clock_hz=1_000_000, board="scripted")
                self._started = None
                self._send(Heartbeat(1000, 0, 0))
                return
            if self._is_silent():
                return
            self.sent += self._per_frame
            if first in self.dropped:
                self._dropped_before += self._per_frame
                continue
            frame = encode(self._data(first, self._per_frame, self._dropped_before), self._sequence)
            self._dropped_before = 0
            self._sequence += 1
            self._out += self.mangle(first, frame)

    def _sent_blocks(self) -> list[int]:
        return [first for first in range(0, self.sent, self._per_frame) if first not in self.dropped]

    def _end(self) -> None:
        check = 0
        for first in self._sent_blocks():
            check = crc32(self._data(first, self._per_frame).samples, check)
        self._send(End(self.sent, self.sent - len(self._sent_blocks()) * self._per_frame, check))

    def _resend(self, sequence: int, request: Resend) -> None:
        first = max(request.first, self.sent - self.held)
        for at in range(first, request.first + request.count, self._per_frame):
            n = min(self._per_frame, request.first + request.count - at)
            frame = encode(self._data(at, n), self._sequence)
            self._sequence += 1
            self._out += frame
        kind = TYPE_OF[Resend]
        held = first == request.first
        self._send(Ack(sequence, kind) if held else Nack(sequence, kind, NackCode.NOT_HELD, "too old"))
