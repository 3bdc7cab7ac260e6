"""Text of strangers in one line: what a board, a file or a session's metadata say can forge no line of what is printed."""

from collections.abc import Iterable
from dataclasses import fields, replace
from typing import Annotated, Any, TypeVar

from pydantic import AfterValidator, ValidationError

from firmware_protocol import Message, OtherVersion

_M = TypeVar("_M", bound=Message | OtherVersion)

_CONTROL = [*range(0x20), *range(0x7F, 0xA0)]
_BREAKS_AND_TURNS = [*range(0x2028, 0x202F), *range(0x2066, 0x206A)]
_REPLACED = dict.fromkeys([*_CONTROL, *_BREAKS_AND_TURNS], "\N{REPLACEMENT CHARACTER}")


def one_line(text: str) -> str:
    """Return `text` with every control character, line break and turn of direction replaced by a mark."""
    return text.translate(_REPLACED)


def in_one_line(message: _M) -> _M:
    """Return a message of a board with each of its texts in one line; those of DESCRIBE are made so in its `Channel`s."""
    texts: dict[str, Any] = {
        field.name: one_line(text)
        for field in fields(message)
        if isinstance(text := getattr(message, field.name), str)
    }
    return replace(message, **texts)


def distinct(names: Iterable[str], sign: str, taken: Iterable[str] = ()) -> tuple[str, ...]:
    """Return the names, each followed by `sign` and its number where there is one like it already: a, a 2, a 3."""
    given = list(taken)
    before = len(given)
    for name in names:
        new, number = name, 1
        while new in given:
            number += 1
            new = f"{name}{sign}{number}"
        given.append(new)
    return tuple(given[before:])


def first_fault(error: ValidationError) -> str:
    """Say where the first fault of a validation is, members of a list counted from 1, and what it is."""
    first = error.errors(include_url=False, include_input=False)[0]
    where = ".".join(str(part + 1 if isinstance(part, int) else part) for part in first["loc"])[:200]
    said = first["msg"].removeprefix("Value error, ")
    return f"{where}: {said}" if where else said


Line = Annotated[str, AfterValidator(one_line)]
"""A text that is made one line when it is read."""


def counted(count: int, one: str, several: str) -> str:
    """Return a count with the words for one or for several."""
    return f"{count} {one if count == 1 else several}"
