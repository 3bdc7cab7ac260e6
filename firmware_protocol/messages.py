"""The vocabulary of the wire: one frozen dataclass per message, in SI units or the unit in the name.

Which bytes carry them is the table in `layout.py`; what they mean to each other is `docs/protocol.md`.
Times are microseconds of the board's clock since its boot. Sample indices count from 0 at each START.
"""

from dataclasses import dataclass
from enum import IntEnum
from typing import Self

PROTOCOL_MAJOR = 1
PROTOCOL_MINOR = 1
NO_CHANNEL = 255
NO_SAMPLE = 2**64 - 1


class SampleFormat(IntEnum):
    """How one number of a DATA message is written, little-endian."""

    I16 = 1
    I32 = 2
    F32 = 3
    F64 = 4

    @property
    def size(self) -> int:
        """Bytes of one number."""
        return _SIZES[self]

    @property
    def code(self) -> str:
        """The same as a numpy data type: `numpy.frombuffer(data.samples, data.format.code)`."""
        return _CODES[self]


_SIZES = {SampleFormat.I16: 2, SampleFormat.I32: 4, SampleFormat.F32: 4, SampleFormat.F64: 8}
_CODES = {SampleFormat.I16: "<i2", SampleFormat.I32: "<i4", SampleFormat.F32: "<f4", SampleFormat.F64: "<f8"}


class _Known(IntEnum):
    """A number of the wire; each kind has a member OTHER for those that are not known here."""

    @classmethod
    def _missing_(cls, value: object) -> Self:
        return cls["OTHER"]


class ResetCause(_Known):
    """Why the board booted last; a value that this version does not know reads as OTHER."""

    POWER_ON = 1
    PIN = 2
    WATCHDOG = 3
    BROWNOUT = 4
    SOFTWARE = 5
    OTHER = 255


class NackCode(_Known):
    """Why the board refused a request; a value that this version does not know reads as OTHER."""

    NOT_UNDERSTOOD = 1
    BUSY = 2
    UNSUPPORTED = 3
    NOT_HELD = 4
    SENSOR = 5
    LIMIT = 6
    STALE = 7
    NOTHING_HELD = 8
    HOLDER = 9
    OTHER = 255


class HolderState(_Known):
    """What the board's holder does with the mass; a value that this version does not know reads as OTHER."""

    FREE = 1
    MOVING = 2
    HELD = 3
    LETTING_GO = 4
    OTHER = 255


class HolderReason(_Known):
    """Why the holder is in its state; a value that this version does not know reads as OTHER."""

    BOOT = 1
    REQUEST = 2
    STOP = 3
    SILENCE = 4
    CONTACT = 5
    FAULT = 6
    OTHER = 255


class EventKind(_Known):
    """What happened to samples; a value that this version does not know reads as OTHER."""

    OVERRUN = 1
    SATURATION = 2
    SENSOR_FAULT = 3
    OTHER = 255


@dataclass(frozen=True)
class HelloRequest:
    """Host to board: who are you? The board answers HELLO, then DESCRIBE, in any state."""

    major: int = PROTOCOL_MAJOR
    minor: int = PROTOCOL_MINOR


@dataclass(frozen=True)
class Hello:
    """Board to host: which protocol it speaks and which boot this is (`boot_id` is random per boot)."""

    boot_id: int
    clock_hz: int
    reset_cause: ResetCause = ResetCause.OTHER
    major: int = PROTOCOL_MAJOR
    minor: int = PROTOCOL_MINOR
    firmware: str = ""
    board: str = ""
    unique_id: str = ""


@dataclass(frozen=True)
class ChannelDescription:
    """One channel: `value = scale * number + offset` in `unit`, for each number of DATA.

    `quantity` is displacement, velocity, acceleration, force or other; `unit` the SI unit of the value.
    `low` and `high` (the range) and `resolution` are in that unit, None when unknown. `rate_hz` is what the
    board samples at; `group_delay_s` how late the channel is for its own filter.
    """

    name: str
    quantity: str
    unit: str
    scale: float
    offset: float
    rate_hz: float
    low: float | None = None
    high: float | None = None
    resolution: float | None = None
    group_delay_s: float = 0.0
    sensor: str = ""


@dataclass(frozen=True)
class Describe:
    """Board to host: its channels, in the order of the numbers in DATA, and the format these come in."""

    format: SampleFormat
    channels: tuple[ChannelDescription, ...]


@dataclass(frozen=True)
class Config:
    """Host to board, while idle: settings for the next START. 0 or None leaves the choice to the board.

    The board answers ACK and then DESCRIBE with what it will really do, or NACK and changes nothing.
    """

    rate_hz: float = 0.0
    samples_per_frame: int = 0
    format: SampleFormat | None = None


@dataclass(frozen=True)
class Start:
    """Host to board: sample from index 0 on, `count` samples or, with 0, until STOP."""

    count: int = 0


@dataclass(frozen=True)
class Stop:
    """Host to board: stop sampling, and let go slowly of a mass that is held; answered by ACK, the DATA still
    waiting, then END.

    While idle it is answered by ACK and the END of the last capture again.
    """


@dataclass(frozen=True)
class Resend:
    """Host to board, after END: send samples `first` to `first + count - 1` again.

    The board sends the ones it still holds as DATA, then ACK, or NACK NOT_HELD when some are missing.
    """

    first: int
    count: int


@dataclass(frozen=True)
class TimeSync:
    """Host to board with its own clock and 0; back with the host's number and the board's clock filled in."""

    host_time_us: int
    board_time_us: int = 0


@dataclass(frozen=True)
class Hold:
    """Host to board: take the mass to this displacement (m, from its place at rest) and hold it there.

    `ticket` is the one of the newest HOLDER. Answered by ACK, then by a HOLDER when the state changes, or by NACK
    LIMIT, STALE, BUSY or HOLDER, and then nothing moves.
    """

    ticket: int
    displacement: float


@dataclass(frozen=True)
class Release:
    """Host to board: let go of the held mass at once; `ticket` as in HOLD.

    Answered by ACK, then by the HOLDER that says at which sample, or by NACK NOTHING_HELD or STALE.
    """

    ticket: int


@dataclass(frozen=True)
class Ack:
    """Board to host: the request with that frame sequence and type was carried out."""

    request_sequence: int
    request_type: int


@dataclass(frozen=True)
class Nack:
    """Board to host: the request was refused, why, and a sentence for the operator."""

    request_sequence: int
    request_type: int
    code: NackCode
    text: str = ""


@dataclass(frozen=True)
class Data:
    """Board to host: `n` samples of `channels` numbers each, sample by sample, from index `first_index` on.

    `samples` holds n * channels numbers of `format`: sample 0 of every channel, then sample 1, and so on.
    `board_time_us` is when sample `first_index` was taken. `dropped_before` counts the samples right
    before it that the board took or should have taken and never sent; their indices are skipped.
    """

    first_index: int
    board_time_us: int
    dropped_before: int
    n: int
    channels: int
    format: SampleFormat
    samples: bytes


@dataclass(frozen=True)
class Heartbeat:
    """Board to host, twice a second while idle: alive."""

    uptime_us: int
    buffer_fill_percent: int
    dropped_total: int


@dataclass(frozen=True)
class Event:
    """Board to host: something happened to samples `index` to `index + count - 1` (channel 255: all of them)."""

    kind: EventKind
    index: int
    count: int = 1
    channel: int = NO_CHANNEL
    text: str = ""


@dataclass(frozen=True)
class End:
    """Board to host: the capture is over. Indices 0 to `total_samples - 1` were taken, of which
    `total_dropped` were never sent; `checksum` is the CRC-32 of all samples sent, in order, once each.
    """

    total_samples: int
    total_dropped: int
    checksum: int


@dataclass(frozen=True)
class Log:
    """Board to host: a line for the operator or the firmware's author."""

    text: str


@dataclass(frozen=True)
class Clock:
    """Board to host, behind DESCRIBE: by how much the clock that times the samples may be off, in ppm of its rate."""

    error_ppm: float


@dataclass(frozen=True)
class Holder:
    """Board to host, behind DESCRIBE, at each change and, unless FREE, four times a second: what holds the mass.

    It holds at displacements from `low` to `high` (m), and lets go slowly when no host was heard for `silence_s`.
    The next HOLD or RELEASE must carry `ticket`. `displacement` is where the mass is held or taken to; `sample`
    the first one of this capture that was taken after a RELEASE, NO_SAMPLE when there is none.
    """

    low: float
    high: float
    silence_s: float
    ticket: int
    state: HolderState
    reason: HolderReason
    displacement: float = 0.0
    sample: int = NO_SAMPLE


@dataclass(frozen=True)
class OtherVersion:
    """A sound frame of another major version. It has no encoding: only the decoder makes it.

    What the rest of the frame means is unknown; the station refuses it in words.
    """

    major: int


Message = (
    HelloRequest
    | Hello
    | Describe
    | Config
    | Start
    | Stop
    | Resend
    | TimeSync
    | Hold
    | Release
    | Ack
    | Nack
    | Data
    | Heartbeat
    | Event
    | End
    | Log
    | Clock
    | Holder
)
