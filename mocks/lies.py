"""A grammar of lies: how one message of a board may be changed, doubled, swallowed or made up before it is sent."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from enum import IntEnum
from struct import pack
from typing import Any
from zlib import crc32

import numpy as np
from cobs import cobs

from firmware_protocol import (
    TYPE_OF,
    Ack,
    ChannelDescription,
    Data,
    Describe,
    End,
    Event,
    EventKind,
    Heartbeat,
    Hello,
    Log,
    Message,
    Nack,
    NackCode,
    SampleFormat,
    TimeSync,
    encode,
)

#: Kinds of lies about a message, and how often each is told where it is told at all.
KINDS = {
    "swallowed": 1.0,
    "doubled": 1.0,
    "late": 1.0,
    "damaged": 1.0,
    "cut": 0.5,
    "noise": 0.5,
    "field": 3.0,
    "samples": 1.0,
    "short body": 0.5,
    "stream": 0.5,
    "sequence": 0.5,
    "version": 0.1,
    "made up": 1.5,
}
TEXTS = ("", "x", "verdict: OK", "a\nb", "\x1b[2J", "mm", "acceleration", "displacement", "N", "y" * 80)
REALS = (0.0, -1.0, 1e-300, 1e300, math.nan, math.inf, 256.0, 257.0, 255.9, 1.0)


class Liar:
    """Turns messages into bytes, with lies of the `kinds` given, each message with probability `odds`."""

    def __init__(self, random: np.random.Generator, kinds: tuple[str, ...], odds: float) -> None:
        self._random = random
        self._kinds = kinds
        self._weights = np.array([KINDS[kind] for kind in kinds])
        self._odds = odds
        self._sequence = 0
        self._held = b""
        self.told: list[str] = []

    def send(self, message: Message) -> bytes:
        """Return the bytes that leave the board when it means to send `message`."""
        out, self._held = self._held, b""
        if not self._kinds or self._random.random() >= self._odds:
            return self._frame(message) + out
        weights = self._weights / self._weights.sum()
        kind = str(self._random.choice(np.array(self._kinds), p=weights))
        self.told.append(f"{kind}: {type(message).__name__}")
        return self._lie(kind, message) + out

    def _frame(self, message: Message, **header: Any) -> bytes:
        sequence, self._sequence = self._sequence, (self._sequence + 1) & 0xFFFFFFFF
        try:
            return encode(message, header.pop("sequence", sequence), **header)
        except ValueError:  # a lie too large for the wire
            return b""

    def _lie(self, kind: str, message: Message) -> bytes:
        random = self._random
        if kind == "swallowed":
            self._sequence += int(random.integers(2))
            return b""
        if kind == "field":
            return self._frame(self._changed(message))
        if kind == "samples":
            return self._frame(_other_samples(message, random))
        if kind == "made up":
            return self._frame(self._made_up(message)) + self._frame(message)
        if kind == "short body":
            return self._short(message)
        if kind == "stream":
            return self._frame(message, stream=int(random.integers(1, 4)))
        if kind == "sequence":
            return self._frame(message, sequence=int(random.integers(1 << 32)))
        if kind == "version":
            return self._frame(message, version=int(random.choice([0, 2, 255])))
        frame = self._frame(message)
        if kind == "doubled":
            return frame + (frame if random.random() < 0.5 else self._frame(message))
        if kind == "late":
            self._held = frame
            return b""
        return self._spoilt(kind, frame)

    def _spoilt(self, kind: str, frame: bytes) -> bytes:
        random = self._random
        if kind == "noise":
            return random.bytes(int(random.integers(1, 2000))) + frame
        if kind == "cut":
            return frame[: int(random.integers(len(frame)))]
        data = bytearray(frame)
        for _ in range(int(random.integers(1, 4)) if data else 0):
            data[int(random.integers(len(data)))] ^= 1 << int(random.integers(8))
        return bytes(data)

    def _short(self, message: Message) -> bytes:
        """Return a frame with a sound checksum around the beginning of a body."""
        frame = self._frame(message)
        plain = cobs.decode(frame[:-1])[:-4]
        kept = plain[: int(self._random.integers(8, len(plain) + 1))]
        return bytes(cobs.encode(kept + pack("<I", crc32(kept)))) + b"\0"

    def _changed(self, message: Message) -> Message:
        """Return the message with one of its fields drawn anew."""
        if isinstance(message, Describe) and self._random.random() < 0.9:
            at = int(self._random.integers(len(message.channels)))
            channels = list(message.channels)
            channels[at] = self._with_other_field(channels[at])
            if self._random.random() < 0.2:
                channels.append(channels[at])
            return replace(message, channels=tuple(channels))
        changed: Message = self._with_other_field(message)
        return changed

    def _with_other_field(self, value: Any) -> Any:
        names = [field.name for field in fields(value) if field.name not in ("samples", "channels")]
        if not names:
            return value
        name = str(self._random.choice(np.array(names)))
        other = self._drawn(getattr(value, name))
        return replace(value, **{name: other})

    def _drawn(self, value: Any) -> Any:
        random = self._random
        if isinstance(value, SampleFormat | IntEnum):
            return random.choice(np.array(list(type(value)), dtype=object))
        if isinstance(value, str):
            return str(random.choice(np.array(TEXTS)))
        if isinstance(value, int) and not isinstance(value, bool):
            near = value + int(random.choice([-16, -7, -1, 1, 7, 16, 768]))
            far = 1 << int(random.integers(0, 65))
            return int(max(random.choice(np.array([near, far, far - 1, 0], dtype=object)), 0))
        if value is None or isinstance(value, float):
            scaled = (value or 1.0) * float(random.choice([1 + 1e-3, 2.0, -1.0]))
            return float(random.choice([scaled, float(random.choice(np.array(REALS)))]))
        return value

    def _made_up(self, message: Message) -> Message:
        """Return a message that nobody asked for."""
        random = self._random
        number, code = int(random.integers(2000)), int(random.choice(list(TYPE_OF.values())))
        small: list[Message] = [
            Hello(boot_id=number, clock_hz=1, board="another"),
            End(number, int(random.integers(3)), number),
            End(1 << 63, 0, 0),
            Ack(int(random.integers(20)), code),
            Nack(int(random.integers(20)), code, NackCode.BUSY, str(random.choice(np.array(TEXTS)))),
            Event(EventKind(int(random.integers(1, 4))), number, int(random.integers(40)), 255),
            Log(str(random.choice(np.array(TEXTS)))),
            Heartbeat(number, 100, number),
            TimeSync(number, number),
            Describe(SampleFormat.F64, (ChannelDescription("z", "other", "1", 2.0, 0.0, 256.0),)),
            Data(number, number, number % 3, 1, 2, SampleFormat.F64, bytes(16)),
        ]
        if isinstance(message, Data):
            small.append(replace(message, first_index=number))
        return small[int(random.integers(len(small)))]


def _other_samples(message: Message, random: np.random.Generator) -> Message:
    """Return DATA with some of its bytes changed."""
    if not isinstance(message, Data) or not message.samples:
        return message
    data = bytearray(message.samples)
    for _ in range(int(random.integers(1, 9))):
        data[int(random.integers(len(data)))] ^= int(random.integers(1, 256))
    return replace(message, samples=bytes(data))
