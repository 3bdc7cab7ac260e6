"""Texts from a board, made one line of plain characters, so that none can forge a line of what is printed."""

from dataclasses import fields, replace
from typing import Any, TypeVar

from firmware_protocol import ChannelDescription, Describe, Event, Hello, Log, Message, Nack

_M = TypeVar("_M", bound=Message)
_T = TypeVar("_T", bound=Message | ChannelDescription)

REPLACED = "\N{REPLACEMENT CHARACTER}"
DIRECTION = {chr(code) for code in (*range(0x202A, 0x202F), *range(0x2066, 0x206A))}


def one_line(text: str) -> str:
    """Return `text` with every control character, line break and turn of direction replaced by a mark."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() and c not in DIRECTION else REPLACED for c in text)


def in_one_line(message: _M) -> _M:
    """Return a message with each of its texts in one line; messages without text as they are."""
    if isinstance(message, Describe):
        return replace(message, channels=tuple(_plain(channel) for channel in message.channels))
    return _plain(message) if isinstance(message, Hello | Event | Log | Nack) else message


def _plain(value: _T) -> _T:
    texts: dict[str, Any] = {
        field.name: one_line(text)
        for field in fields(value)
        if isinstance(text := getattr(value, field.name), str)
    }
    return replace(value, **texts)
