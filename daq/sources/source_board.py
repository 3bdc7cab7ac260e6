"""A source behind the protocol: it answers requests and sends its samples as DATA, as a board would.

So a capture from any source has the same trigger, the same session and the same verdict. Samples travel as 64-bit
numbers in SI units. The source's own bytes are handed to `keep` before its samples are.
"""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from zlib import crc32

import numpy as np

from daq.description_checks import data_of, description_of
from daq.recording import Array
from daq.sources.source import Reading, Source, SourceDescription
from firmware_protocol import (
    TYPE_OF,
    Ack,
    Config,
    Decoder,
    End,
    Frame,
    Heartbeat,
    Hello,
    HelloRequest,
    Log,
    Message,
    Nack,
    NackCode,
    Resend,
    Start,
    Stop,
    encode,
)

ROOM = 900
"""Bytes of samples in a frame."""

EVEN_SAMPLES = 0.1
"""How far a sample's own time may be from that of its place in a frame, which carries the first's only, in samples."""

HEARTBEAT_S = 0.4
IDLE_S = 0.02


@dataclass
class _Run:
    """What was sampled since START."""

    sampling: bool = False
    total: int = 0
    dropped: int = 0
    checksum: int = 0


class SourceBoard:
    """A port (see `daq.port.Port`) at which a source answers as a board. Safe for one reader and one writer thread.

    `description` is what the source gives.
    """

    def __init__(self, source: Source) -> None:
        self._source = source
        self.description: SourceDescription = source.describe()
        self.name = self.description.name
        self.keep: Callable[[bytes], object] = len
        self._decoder = Decoder()
        self._frames: list[bytes] = []  # that wait to be read
        self._sequence = 0
        self._run = _Run()
        self._lock = threading.Lock()
        self._booted = time.monotonic()
        self._beat = self._booted

    def read(self) -> bytes:
        """Return the frames that are due; b"" when nothing came within about 50 ms."""
        if self._run.sampling:
            readings = self._source.read()
            with self._lock:
                for reading in readings:
                    if reading.raw:
                        self.keep(reading.raw)
                    if self._run.sampling:
                        self._take(reading)
        elif not self._frames:
            time.sleep(IDLE_S)
        with self._lock:
            now = time.monotonic()
            if now - self._beat > HEARTBEAT_S:
                self._beat = now
                self._say(Heartbeat(int((now - self._booted) * 1e6), 0, self._run.dropped))
            frames, self._frames = self._frames, []
        return b"".join(frames)

    def write(self, data: bytes) -> None:
        """Take requests."""
        with self._lock:
            for frame in self._decoder.feed(data):
                self._answer(frame)

    def close(self) -> None:
        """Give the source back."""
        self._source.close()

    def _answer(self, frame: Frame) -> None:
        message = frame.message
        if isinstance(message, HelloRequest):
            self._say(
                Hello(boot_id=1, clock_hz=1_000_000, firmware="a source of samples", board=self.name[:200])
            )
            self._say(description_of(self.description.channels, self.description.rate_hz))
            for remark in self.description.remarks:
                self._say(Log(remark[:250]))
        elif isinstance(message, Stop):
            self._ack(frame, message)
            self._run.sampling = False
            self._say(End(self._run.total, self._run.dropped, self._run.checksum))
        elif isinstance(message, Start):
            self._source.start()
            self._run = _Run(sampling=True)
            self._ack(frame, message)
        elif isinstance(message, Config):
            self._ack(frame, message)
            self._say(description_of(self.description.channels, self.description.rate_hz))
        elif isinstance(message, Resend):
            text = "a source keeps no samples"
            self._say(Nack(frame.sequence, TYPE_OF[Resend], NackCode.NOT_HELD, text))

    def _say(self, message: Message) -> None:
        self._frames.append(encode(message, self._sequence))
        self._sequence = (self._sequence + 1) & 0xFFFFFFFF

    def _ack(self, frame: Frame, message: Message) -> None:
        self._say(Ack(frame.sequence, TYPE_OF[type(message)]))

    def _take(self, reading: Reading) -> None:
        """Send samples as DATA; indices that were skipped are said to be dropped."""
        run = self._run
        samples = reading.samples
        if not len(samples):
            return
        skipped = reading.first - run.total
        run.dropped += skipped
        size = max(1, ROOM // (8 * samples.shape[1]))
        rate = self.description.rate_hz
        times: Array = (reading.first + np.arange(len(samples), dtype=np.float64)) * 1e6 / rate
        if reading.times_us is not None:
            times = reading.times_us
        at = 0
        while at < len(samples):
            part = samples[at : at + _even(times[at : at + size], rate)]
            data = data_of(reading.first + at, float(times[at]), part, skipped if at == 0 else 0)
            run.checksum = crc32(data.samples, run.checksum)
            self._say(data)
            at += len(part)
        run.total = reading.first + len(samples)


def _even(times_us: Array, rate: float) -> int:
    """Count the samples that one time can describe: those whose own times, shape (n,), follow the first evenly."""
    late = (times_us - times_us[0]) * 1e-6 * rate - np.arange(len(times_us))
    odd = np.flatnonzero(~(np.abs(late) <= EVEN_SAMPLES))
    return max(int(odd[0]), 1) if len(odd) else len(times_us)
