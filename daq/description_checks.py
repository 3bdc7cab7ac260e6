"""Descriptions from a board and notes in a raw log, checked before they are used."""

from dataclasses import dataclass
from math import isfinite
from typing import Any

from daq.recording import Channel, Gap
from firmware_protocol import Describe

MAX_RATE = 1e7
MAX_ITEMS = 20_000


@dataclass(frozen=True)
class Window:
    """The part of the stream that is the recording: `count` samples from `first`, released at `trigger`."""

    first: int
    count: int
    trigger: int | None = None


def channels_of(description: Describe) -> tuple[Channel, ...]:
    """Return the channels of a description that was found sound."""
    return tuple(
        Channel(
            name=c.name,
            quantity=c.quantity,
            unit=c.unit,
            resolution=c.resolution,
            low=c.low,
            high=c.high,
            group_delay_s=c.group_delay_s,
            sensor=c.sensor,
        )
        for c in description.channels
    )


def problem_of(description: Describe) -> str | None:
    """Return what makes a description unusable, in words, or None."""
    if not description.channels:
        return "the board describes no channel"
    for channel in description.channels:
        if not (isfinite(channel.rate_hz) and 0 < channel.rate_hz <= MAX_RATE):
            return f"the board gives channel {channel.name!r} a rate of {channel.rate_hz:g} Hz"
        if not (isfinite(channel.scale) and isfinite(channel.offset)) or channel.scale == 0:
            return f"the board gives channel {channel.name!r} a scale of {channel.scale:g}"
    rates = {channel.rate_hz for channel in description.channels}
    if len(rates) > 1:
        return "the board describes channels of different rates: " + ", ".join(f"{r:g} Hz" for r in rates)
    return None


def items_of(note: dict[str, Any], key: str) -> list[Any]:
    """Return a list out of a note, cut to a sensible length; empty when there is none."""
    value = note.get(key)
    return value[:MAX_ITEMS] if isinstance(value, list) else []


def _whole(value: object, limit: int = 1 << 62) -> bool:
    return type(value) is int and 0 <= value <= limit


def gap_of(item: object) -> Gap | None:
    """Return a gap that was noted as [first, count, reason], or None."""
    match item:
        case [int(first), int(count), str(reason)] if _whole(first) and _whole(count):
            return Gap(first, count, reason)
    return None


def window_of(note: dict[str, Any]) -> Window | None:
    """Return the window in a note, or None."""
    match note:
        case {"first": int(first), "count": int(count)} if _whole(first) and _whole(count):
            trigger = note.get("trigger")
            return Window(first, count, trigger if isinstance(trigger, int) and _whole(trigger) else None)
    return None
