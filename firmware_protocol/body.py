"""Message bodies: a dataclass to bytes and back, by the byte table of `layout.py`."""

from collections.abc import Callable
from math import isnan, nan
from struct import (
    Struct,
    error as StructError,  # noqa: N812
)
from typing import Any, cast

from firmware_protocol.layout import (
    CHANNEL_FIELDS,
    FORMAT_OR_NONE,
    NUMBER_OR_NAN,
    TABLE,
    TEXT,
    TYPE_OF,
    Fields,
    Kind,
)
from firmware_protocol.messages import ChannelDescription, Data, Describe, Message, SampleFormat

MAX_TEXT = 255
MAX_CHANNELS = 255


class MalformedError(ValueError):
    """The checksum is right and the bytes still make no message: the sender's mistake."""


def _to_number(kind: Kind, value: Any) -> Any:
    if kind is NUMBER_OR_NAN:
        return nan if value is None else value
    if kind is FORMAT_OR_NONE:
        return 0 if value is None else value
    return value


def _from_number(kind: Kind, number: Any) -> Any:
    if kind is NUMBER_OR_NAN:
        return None if isnan(number) else number
    if kind is FORMAT_OR_NONE and number == 0:
        return None
    return number if kind.means is None else kind.means(number)


def _write_text(text: str) -> bytes:
    data = text.encode("utf-8")
    if len(data) > MAX_TEXT:
        raise ValueError(f"a text of {len(data)} bytes; the wire carries at most {MAX_TEXT}")
    return bytes((len(data),)) + data


def _read_text(body: bytes, at: int) -> tuple[str, int]:
    end = at + 1 + body[at] if at < len(body) else at + 1
    if end > len(body):
        raise MalformedError("a text runs past the end of the body")
    return body[at + 1 : end].decode("utf-8", errors="replace"), end


class FieldsCodec:
    """Numbers, then texts, of one dataclass; tails other than texts are left to the caller."""

    def __init__(self, cls: Callable[..., Any], fields: Fields) -> None:
        self.cls = cls
        self.numbers = tuple((name, kind) for name, kind in fields if kind.code)
        self.texts = tuple(name for name, kind in fields if kind is TEXT)
        self.struct = Struct("<" + "".join(kind.code for _, kind in self.numbers))

    def write(self, value: object) -> bytes:
        """Return the bytes of numbers and texts."""
        numbers = [_to_number(kind, getattr(value, name)) for name, kind in self.numbers]
        texts = [_write_text(getattr(value, name)) for name in self.texts]
        return self.struct.pack(*numbers) + b"".join(texts)

    def read(self, body: bytes) -> tuple[dict[str, Any], int]:
        """Return the fields by name, and where the bytes after them begin."""
        values = zip(self.numbers, self.struct.unpack_from(body), strict=True)
        fields = {name: _from_number(kind, number) for (name, kind), number in values}
        at = self.struct.size
        for name in self.texts:
            fields[name], at = _read_text(body, at)
        return fields, at

    def message(self, body: bytes) -> Message:
        """Return the dataclass; bytes after its last field are skipped."""
        return cast(Message, self.cls(**self.read(body)[0]))


_CODECS = {cls: FieldsCodec(cls, fields) for _, cls, fields in TABLE}
_CHANNEL = FieldsCodec(ChannelDescription, CHANNEL_FIELDS)
_FORMATS = {int(form): (form, form.size) for form in SampleFormat}


def _write_channels(channels: tuple[ChannelDescription, ...]) -> bytes:
    if len(channels) > MAX_CHANNELS:
        raise ValueError(f"{len(channels)} channels; the wire carries at most {MAX_CHANNELS}")
    records = [_CHANNEL.write(channel) for channel in channels]
    lengths = [len(record).to_bytes(2, "little") for record in records]
    return bytes((len(records),)) + b"".join(a + b for a, b in zip(lengths, records, strict=True))


def _read_channels(body: bytes, at: int) -> tuple[ChannelDescription, ...]:
    if at >= len(body):
        raise MalformedError("the number of channels is missing")
    channels = []
    count, at = body[at], at + 1
    for _ in range(count):
        start = at + 2
        at = start + int.from_bytes(body[at:start], "little")
        if start > len(body) or at > len(body):
            raise MalformedError("a channel runs past the end of the body")
        channels.append(ChannelDescription(**_CHANNEL.read(body[start:at])[0]))
    return tuple(channels)


def _samples(data: Data) -> bytes:
    if len(data.samples) != data.n * data.channels * data.format.size:
        raise ValueError(
            f"{len(data.samples)} bytes of samples, but n, channels and format make "
            f"{data.n} x {data.channels} x {data.format.size}"
        )
    return data.samples


def write_body(message: Message) -> bytes:
    """Return the body of a message; ValueError when a value does not fit its field."""
    codec = _CODECS.get(type(message))
    if codec is None:
        raise ValueError(f"{type(message).__name__} is no message of the wire")
    try:
        body = codec.write(message)
        if isinstance(message, Data):
            return body + _samples(message)
        if isinstance(message, Describe):
            return body + _write_channels(message.channels)
    except (StructError, OverflowError, UnicodeError) as error:
        raise ValueError(f"{type(message).__name__} does not fit the wire: {error}") from error
    return body


def _read_data(body: bytes) -> Message:
    first, time, dropped, n, channels, code = _DATA.unpack_from(body)
    form, size = _FORMATS[code]
    end = _DATA.size + n * channels * size
    if end > len(body):
        raise MalformedError("DATA holds fewer samples than it says")
    # A frozen dataclass sets its fields one by one through object.__setattr__, a third of the time that a
    # short frame takes. DATA is nearly all of the traffic, so its dict is filled at once.
    data = object.__new__(Data)
    data.__dict__.update(
        first_index=first,
        board_time_us=time,
        dropped_before=dropped,
        n=n,
        channels=channels,
        format=form,
        samples=body[_DATA.size : end],
    )
    return data


def _read_describe(body: bytes) -> Message:
    fields, at = _CODECS[Describe].read(body)
    return Describe(**fields, channels=_read_channels(body, at))


_DATA = _CODECS[Data].struct
_READERS: dict[int, Callable[[bytes], Message]] = {code: _CODECS[cls].message for code, cls, _ in TABLE}
_READERS |= {TYPE_OF[Data]: _read_data, TYPE_OF[Describe]: _read_describe}


def read_body(code: int, body: bytes) -> Message | None:
    """Return the message of that type code, None when this version knows no such type.

    MalformedError when the bytes make no message of that type.
    """
    reader = _READERS.get(code)
    if reader is None:
        return None
    try:
        return reader(body)
    except (StructError, KeyError, ValueError) as error:
        raise MalformedError(str(error)) from error
