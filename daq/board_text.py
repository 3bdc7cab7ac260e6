"""Texts from a board, made one line of plain characters, so that none can forge a line of what is printed."""

from dataclasses import fields, replace
from typing import Any, TypeVar

from daq.plain_text import one_line
from firmware_protocol import Event, Hello, Log, Message, Nack

_M = TypeVar("_M", bound=Message)


def in_one_line(message: _M) -> _M:
    """Return a message with each of its texts in one line; those of DESCRIBE are made so in its `Channel`s."""
    if not isinstance(message, Hello | Event | Log | Nack):
        return message
    texts: dict[str, Any] = {
        field.name: one_line(text)
        for field in fields(message)
        if isinstance(text := getattr(message, field.name), str)
    }
    return replace(message, **texts)
