"""A message as a line of text that Python and C write alike, and a fast seeded source of messages.

`type sequence stream field ...` in the order of the dataclass: integers in decimal, floats as the sixteen
hexadecimal digits of their bits (None as NaN's), texts and samples in hexadecimal behind a `=`; channels as
their number and then the fields of each.
"""

import random
import struct
from dataclasses import fields
from enum import IntEnum
from typing import Any

from firmware_protocol import (
    TYPE_OF,
    Ack,
    ChannelDescription,
    Clock,
    Config,
    Data,
    Describe,
    End,
    Event,
    EventKind,
    Frame,
    Heartbeat,
    Hello,
    HelloRequest,
    Hold,
    Holder,
    HolderReason,
    HolderState,
    Log,
    Message,
    Nack,
    NackCode,
    Release,
    Resend,
    ResetCause,
    SampleFormat,
    Start,
    Stop,
    TimeSync,
)

NAN_BITS = "7ff8000000000000"
FIELD_NAMES = {cls: tuple(f.name for f in fields(cls)) for cls in (*TYPE_OF, ChannelDescription)}


def _words(name: str, value: Any) -> str:
    if isinstance(value, int):
        return str(int(value))
    if isinstance(value, float):
        return struct.pack(">d", value).hex()
    if isinstance(value, str):
        return "=" + value.encode().hex()
    if isinstance(value, bytes):
        return "=" + value.hex()
    if isinstance(value, tuple):
        return " ".join([str(len(value)), *map(fields_of, value)])
    assert value is None
    return "0" if name == "format" else NAN_BITS


def fields_of(message: Any) -> str:
    """The fields of a message or a channel, in order."""
    return " ".join(_words(name, getattr(message, name)) for name in FIELD_NAMES[type(message)])


def line_of(frame: Frame) -> str:
    """The line that both languages write for a frame."""
    return (
        f"{TYPE_OF[type(frame.message)]} {frame.sequence} {frame.stream} {fields_of(frame.message)}".rstrip()
    )


class RandomMessages:
    """Any message, some thousands a second faster than hypothesis; sizes and values favour the ends."""

    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)

    def integer(self, bits: int) -> int:
        choice = self.rng.random()
        if choice < 0.3:
            return self.rng.getrandbits(bits)
        return self.rng.choice((0, 1, 2, 255, 256, 2**bits - 1, 2 ** (bits - 1), 2048)) % 2**bits

    def number(self) -> float:
        return self.rng.choice((0.0, -0.0, 256.0, 1e-6, float("inf"), self.rng.gauss(0, 1e3), 5e-324))

    def maybe(self) -> float | None:
        return None if self.rng.random() < 0.3 else self.number()

    def text(self, longest: int = 255) -> str:
        kind, length = self.rng.random(), self.rng.choice((0, 1, 7, 30))
        if kind < 0.6:
            return "measured at rest, 20 mm"[:length]
        if kind < 0.9:
            return "µm °C ü 加速度 \x00"[: length // 3]
        return "x" * longest

    def member(self, kind: type[IntEnum]) -> Any:
        return self.rng.choice(list(kind))

    def channel(self) -> ChannelDescription:
        quantity = self.rng.choice(("displacement", "acceleration", "other"))
        numbers = (self.number(), self.number(), self.number(), self.maybe(), self.maybe(), self.maybe())
        return ChannelDescription(self.text(9), quantity, "m/s^2", *numbers, self.number(), self.text(9))

    def data(self) -> Data:
        form, channels = self.member(SampleFormat), self.rng.randint(1, 4)
        most = 988 // (channels * form.size)
        n = self.rng.choice((0, 1, 16, most, self.rng.randint(0, most)))
        n = min(n, most)
        size = n * channels * form.size
        samples = self.rng.choice((bytes(size), b"\x01" * size, self.rng.randbytes(size)))
        return Data(self.integer(64), self.integer(64), self.integer(32), n, channels, form, samples)

    def message(self) -> Message:
        i = self.integer
        made: Message
        match self.rng.randrange(19):
            case 0:
                made = HelloRequest(i(8), i(8))
            case 1:
                made = Config(self.number(), i(16), self.rng.choice((None, *SampleFormat)))
            case 2:
                made = Start(i(64))
            case 3:
                made = Stop()
            case 4:
                made = Resend(i(64), i(32))
            case 5:
                made = TimeSync(i(64), i(64))
            case 6:
                texts = (self.text(), self.text(), self.text())
                made = Hello(i(32), i(32), self.member(ResetCause), i(8), i(8), *texts)
            case 7:
                count = self.rng.randint(0, 6)
                made = Describe(self.member(SampleFormat), tuple(self.channel() for _ in range(count)))
            case 8:
                made = Ack(i(32), i(8))
            case 9:
                made = Nack(i(32), i(8), self.member(NackCode), self.text())
            case 10:
                made = Heartbeat(i(64), i(8), i(64))
            case 11:
                made = Event(self.member(EventKind), i(64), i(32), i(8), self.text())
            case 12:
                made = End(i(64), i(64), i(32))
            case 13:
                made = Log(self.text())
            case 14:
                made = Clock(self.number())
            case 15:
                made = Hold(i(32), self.number())
            case 16:
                made = Release(i(32))
            case 17:
                limits = (self.number(), self.number(), self.number())
                state, reason = self.member(HolderState), self.member(HolderReason)
                made = Holder(*limits, i(32), state, reason, self.number(), i(64))
            case _:
                made = self.data()
        return made

    def frame(self) -> Frame:
        return Frame(self.integer(32), self.integer(8), self.message())
