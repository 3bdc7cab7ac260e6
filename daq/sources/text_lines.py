"""Lines of text with numbers in them, as boards print them: separated, `name:value`, or a JSON object.

A line comes from anyone: no pattern here looks twice at what it has passed.
"""

import json
import math
import re

from daq.importing.numbers import parse_number

LONGEST = 4096
MOST_COLUMNS = 64

_NUMBER = r"[-+]?(?:\d++\.?\d*+|\.\d++)(?:[eE][-+]?\d++)?"
_VALUE = re.compile(rf"[:=]\s*+({_NUMBER})(?![\w.])")
_NO_NAME, _LETTER = re.compile(r"[^\w .²^/°-]"), re.compile(r"[^\W\d]")
_BETWEEN = re.compile(r"\s*[,;\t|]\s*|\s+")


class LineCutter:
    """Bytes as they come, to whole lines. What is longer than LONGEST is no line and is thrown away."""

    def __init__(self) -> None:
        self._rest = b""
        self._skipping = True  # the first line may have begun before we listened

    def feed(self, data: bytes) -> list[str]:
        """Return the lines that are complete now."""
        *whole, self._rest = (self._rest + data).split(b"\n")
        if whole and self._skipping:
            whole, self._skipping = whole[1:], False
        if len(self._rest) > LONGEST:
            self._rest, self._skipping = b"", True
        return [line.decode("utf-8", "replace").strip("\r\0 \t") for line in whole if len(line) <= LONGEST]


def parse_line(text: str) -> dict[str, float] | None:
    """Return the numbers of a line by the name of their column, "1", "2" ... where it has no names; None where it is none
    of the forms, or is only drawn. What is not a number there reads as NaN.
    """
    if not any(map(str.isalnum, text)):
        return None
    if text.startswith("{"):
        return _from_json(text)
    pairs = _pairs(text)
    if pairs and not _NUMBER_FIRST.match(text):
        return dict(pairs[:MOST_COLUMNS])
    fields = [field for field in _BETWEEN.split(text) if field]
    if not fields or len(fields) > MOST_COLUMNS:
        return None
    numbers = [parse_number(field) for field in fields]
    if any(number is None for number in numbers):
        return None
    return {str(i): n for i, n in enumerate(numbers, 1) if n is not None}


def _pairs(text: str) -> list[tuple[str, float]]:
    """Return each `name:value` or `name = value` of a line; a name begins with a letter."""
    pairs, begin = [], 0
    for found in _VALUE.finditer(text):
        before = _NO_NAME.split(text[begin : found.start()].rstrip())[-1]
        if letter := _LETTER.search(before):
            pairs.append((before[letter.start() :], float(found[1])))
            begin = found.end()
    return pairs


def header_of(text: str) -> tuple[str, ...]:
    """Return the names in a line that is a header: separated words, none of them a number; () where it is none."""
    fields = [field.strip().strip('"') for field in re.split(r"[,;\t|]", text)]
    if len(fields) == 1:
        fields = text.split()
    wordy = all(re.search(r"[^\W\d_]", field) and parse_number(field) is None for field in fields)
    return tuple(fields) if fields and wordy and len(fields) <= MOST_COLUMNS else ()


_NUMBER_FIRST = re.compile(rf"{_NUMBER}\s*(?:[,;\t| ]|$)")


def _from_json(text: str) -> dict[str, float] | None:
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        return None
    members = found.items() if isinstance(found, dict) else ()
    pairs = [pair for name, value in members for pair in _flat(str(name), value)]
    return dict(pairs[:MOST_COLUMNS]) or None


def _flat(name: str, value: object) -> list[tuple[str, float]]:
    if isinstance(value, list):
        return [pair for i, one in enumerate(value[:MOST_COLUMNS], 1) for pair in _flat(f"{name}.{i}", one)]
    if value is None:
        value = math.nan
    if isinstance(value, bool) or not isinstance(value, int | float):
        return []
    return [(name, float(value) if abs(value) < 1e300 else math.nan)]
