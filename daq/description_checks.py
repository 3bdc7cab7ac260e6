"""Descriptions from a board and notes in a raw log, checked before they are used."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Annotated, Any, TypeVar

import numpy as np
from pydantic import Field, TypeAdapter, ValidationError

from daq.plain_text import distinct
from daq.recording import Array, Channel
from firmware_protocol import ChannelDescription, Data, Describe, SampleFormat

MAX_RATE = 1e7
Whole = Annotated[int, Field(strict=True, ge=0, le=1 << 62)]
T = TypeVar("T")
SHARED = ("quantity", "unit", "resolution", "low", "high", "group_delay_s", "sensor")


@dataclass(frozen=True)
class Window:
    """The part of the stream that is the recording: `count` samples from `first`, released at `trigger`."""

    first: Whole
    count: Whole
    trigger: Whole | None = None


@dataclass(frozen=True)
class Imported:
    """What an import knew beside its samples: `gaps` as (first, count, reason), and sentences."""

    gaps: tuple[tuple[Whole, Whole, str], ...] = ()
    notes: tuple[str, ...] = ()


WINDOW, IMPORTED = TypeAdapter(Window), TypeAdapter(Imported)


def channels_of(description: Describe) -> tuple[Channel, ...]:
    """Return the channels of a description that was found sound; of equal names the later ones get a number."""
    names = distinct((c.name for c in description.channels), " ")
    return tuple(
        Channel(name=name, **_shared(c)) for name, c in zip(names, description.channels, strict=True)
    )


def description_of(channels: Sequence[Channel], rate: float) -> Describe:
    """Describe channels whose samples are sent in SI units, as 64-bit numbers, at `rate` Hz."""
    described = (
        ChannelDescription(name=_fitting(c.name), scale=1.0, offset=0.0, rate_hz=rate, **_shared(c))
        for c in channels
    )
    return Describe(SampleFormat.F64, tuple(described))


def data_of(first: int, time_us: float, samples: Array, dropped: int = 0) -> Data:
    """Return samples in SI units, shape (n, channels), as DATA of such a description; `first` was taken at `time_us`."""
    content = np.ascontiguousarray(samples, dtype="<f8").tobytes()
    return Data(first, round(time_us), dropped, len(samples), samples.shape[1], SampleFormat.F64, content)


def _shared(channel: Channel | ChannelDescription) -> dict[str, Any]:
    """Return what a channel and its description on the wire have in common, beside the name."""
    found = {field: getattr(channel, field) for field in SHARED}
    return {field: _fitting(value) if isinstance(value, str) else value for field, value in found.items()}


def _fitting(text: str) -> str:
    """Cut a text to what the wire carries, between two characters."""
    return text.encode()[:255].decode(errors="ignore")


def problem_of(description: Describe) -> str | None:
    """Say what makes a description unusable, or None."""
    if not description.channels:
        return "the board describes no channel"
    for channel in description.channels:
        if not (isfinite(channel.rate_hz) and 0 < channel.rate_hz <= MAX_RATE):
            return f"the board gives channel {channel.name!r} a rate of {channel.rate_hz:g} Hz"
        if not (isfinite(channel.scale) and isfinite(channel.offset)) or channel.scale == 0:
            return f"the board gives channel {channel.name!r} a scale of {channel.scale:g}"
        if not isfinite(channel.group_delay_s):
            return f"the board gives channel {channel.name!r} a delay of {channel.group_delay_s:g} s"
    rates = {channel.rate_hz for channel in description.channels}
    if len(rates) > 1:
        return "the board describes channels of different rates: " + ", ".join(f"{r:g} Hz" for r in rates)
    return None


def noted(kind: TypeAdapter[T], note: dict[str, Any]) -> T | None:
    """Return what a note of the station says, None where it is not understood."""
    try:
        return kind.validate_python(note)
    except ValidationError:
        return None
