"""The incremental decoder: bytes in as they come, sound frames out, everything else counted.

The result depends on the bytes alone, not on how they are cut. Nothing that arrives makes it raise.
"""

from dataclasses import dataclass, replace
from zlib import crc32

from cobs import cobs

from firmware_protocol.body import MalformedError, read_body
from firmware_protocol.frame import DELIMITER, HEADER, MAX_FRAME, MAX_STUFFED, MIN_FRAME, Frame
from firmware_protocol.messages import PROTOCOL_MAJOR, OtherVersion

_RESIDUE = 0x2144DF1C  # CRC-32 of anything followed by its own CRC-32, little-endian


@dataclass
class Statistics:
    """How many frames came and how many pieces between two 0x00 were something else, by reason.

    `frames` counts the frames handed out, those of another major version, too.
    `unknown` is a type of a later minor version, `malformed` a sound checksum around a body that makes
    no message; `why_malformed` says what was wrong with the last of these.
    """

    bytes: int = 0
    frames: int = 0
    bad_cobs: int = 0
    bad_checksum: int = 0
    too_short: int = 0
    too_long: int = 0
    unknown: int = 0
    malformed: int = 0
    why_malformed: str = ""

    @property
    def damaged(self) -> int:
        """Pieces that the wire damaged, or that never were frames."""
        return self.bad_cobs + self.bad_checksum + self.too_short + self.too_long


class Decoder:
    """Feed it bytes; it keeps at most one unfinished frame (under 1100 bytes) between two calls."""

    def __init__(self) -> None:
        self._pending = b""
        self._overlong = False
        self._counts = Statistics()

    @property
    def statistics(self) -> Statistics:
        """A copy of the counts so far."""
        return replace(self._counts)

    def feed(self, data: bytes) -> list[Frame]:
        """Return the frames that these bytes completed, in order."""
        self._counts.bytes += len(data)
        pieces = (self._pending + data).split(DELIMITER)
        self._pending = pieces.pop()
        frames = []
        for piece in pieces:
            if self._overlong:
                self._overlong = False
                self._counts.too_long += 1
            elif piece:
                frame = self._open(piece)
                if frame is not None:
                    frames.append(frame)
        if len(self._pending) > MAX_STUFFED:
            self._overlong = True
            self._pending = b""
        self._counts.frames += len(frames)
        return frames

    def _open(self, piece: bytes) -> Frame | None:
        counts = self._counts
        if len(piece) > MAX_STUFFED:
            counts.too_long += 1
            return None
        try:
            plain = cobs.decode(piece)
        except cobs.DecodeError:
            counts.bad_cobs += 1
            return None
        if len(plain) < MIN_FRAME:
            counts.too_short += 1
        elif len(plain) > MAX_FRAME:
            counts.too_long += 1
        elif crc32(plain) != _RESIDUE:
            counts.bad_checksum += 1
        else:
            return self._read(plain)
        return None

    def _read(self, plain: bytes) -> Frame | None:
        version, code, _, stream, sequence = HEADER.unpack_from(plain)
        if version != PROTOCOL_MAJOR:
            return Frame(sequence, stream, OtherVersion(version))
        try:
            message = read_body(code, plain[HEADER.size : -4])
        except MalformedError as error:
            self._counts.malformed += 1
            self._counts.why_malformed = f"type 0x{code:02X}: {error}"
            return None
        if message is None:
            self._counts.unknown += 1
            return None
        return Frame(sequence, stream, message)
