"""One frame: header, body and CRC-32, stuffed by COBS so that 0x00 stands only between frames."""

from struct import Struct
from typing import NamedTuple
from zlib import crc32

from cobs import cobs

from firmware_protocol.body import write_body
from firmware_protocol.layout import TYPE_OF
from firmware_protocol.messages import PROTOCOL_MAJOR, Message, OtherVersion

DELIMITER = b"\x00"
HEADER = Struct("<BBBBI")  # version, type, flags, stream, sequence
CHECKSUM = Struct("<I")
MIN_FRAME = HEADER.size + CHECKSUM.size
MAX_FRAME = 1024
MAX_STUFFED = MAX_FRAME + -(-MAX_FRAME // 254)
MAX_BODY = MAX_FRAME - MIN_FRAME


class Frame(NamedTuple):
    """What one sound frame carried; `sequence` counts the sender's frames modulo 2**32."""

    sequence: int
    stream: int
    message: Message | OtherVersion


def encode(message: Message, sequence: int, stream: int = 0, *, version: int = PROTOCOL_MAJOR) -> bytes:
    """Return the whole frame, with COBS and the closing 0x00.

    `version` is the header's major version; another one than ours is for tests of the refusal.
    ValueError when a value does not fit its field or the frame is longer than 1024 bytes.
    """
    body = write_body(message)
    if len(body) > MAX_BODY:
        raise ValueError(f"{type(message).__name__} of {len(body)} bytes; a frame carries at most {MAX_BODY}")
    if not 0 <= stream <= 255:
        raise ValueError(f"stream {stream}; the header carries 0 to 255")
    head = HEADER.pack(version, TYPE_OF[type(message)], 0, stream, sequence & 0xFFFFFFFF)
    plain = head + body
    return bytes(cobs.encode(plain + CHECKSUM.pack(crc32(plain)))) + DELIMITER
