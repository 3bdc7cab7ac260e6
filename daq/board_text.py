"""Texts from a board, made one line of plain characters, so that none can forge a line of what is printed."""

from dataclasses import fields, replace
from typing import Any, TypeVar

from daq.plain_text import one_line
from firmware_protocol import ChannelDescription, Describe, Event, Hello, Log, Message, Nack

_M = TypeVar("_M", bound=Message)
_T = TypeVar("_T", bound=Message | ChannelDescription)


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
