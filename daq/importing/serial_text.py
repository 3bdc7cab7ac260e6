"""Text of a serial monitor: `13:05:23.417 -> Distance: 12.3 cm`, `angle:1.25,ref:0`, and cells such as `24.4 cm`."""

import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from daq.importing.errors import MAX_SENTENCES, require_few
from daq.importing.recipe import Format
from daq.importing.units import parse_unit

_ARROW = re.compile(r"\s*(\d{1,2}:\d\d:\d\d(?:[.,]\d+)?)\s*->\s*")
_ITEM = re.compile(
    r"\s*(?:([^\W\d_](?:[\w ./()\[\]°²^-]{0,30}[\w)\]°])?)\s*[:=]\s*)?"  # a label
    r"([-+]?(?:\d++\.?\d*+|\.\d++)(?:[eE][-+]?\d++)?)"  # a number
    r"(?:\s?([^\W\d_][\w/^²]{0,7}|°|%))?"  # its unit
    r"\s*(?:[,;|\t]|\s|$)\s*"
)
_COMMA = re.compile(r"(?<=\d),(?=\d)")

SAMPLE = 40
ALIKE = 0.9
"""Share of the lines that must have the same labels and units: others are greetings of the board, or were cut off."""


_Shape = tuple[bool, tuple[str, ...], tuple[str, ...]]
"""Whether a line begins with a time of day, the labels and the units of its numbers."""


def table_of(path: Path, lines: Sequence[str], decimal: str | None) -> tuple[Format, list[str], str] | None:
    """Return the lines as a table between tabs with a header, and a sentence on it; None where they are no such text.

    Each line stays in its place; what does not fit is blank. Where no line is free above the first row, the header comes
    before all. A comma between two digits is the decimal sign where `decimal` says so, or every number then has a label, or
    every one a unit.
    """
    found = _alike(path, lines) if decimal != "," else None
    if decimal == "," or (decimal is None and found is not None and not _all_named(found[0])):
        found = None  # both at once would be too much
        found = _alike(path, [_COMMA.sub(".", line) for line in lines])
        if decimal is None and (found is None or not _all_named(found[0])):
            found = _alike(path, lines)
    if found is None:
        return None
    (clock, labels, units), rows = found
    named = zip(labels, units, strict=True)
    cells = [f"{name} ({unit})" if name and unit else name or unit for name, unit in named]
    header = "\t".join([*["time"] * clock, *cells])
    first = next(i for i, row in enumerate(rows) if row)
    made = [header, *rows] if first == 0 else [*rows[: first - 1], header, *rows[first:]]
    return "serial", made, "what stands beside the numbers in each row was read: times, labels or units"


def _alike(path: Path, lines: Sequence[str]) -> tuple[_Shape, list[str]] | None:
    """Return the commonest shape and the rows that have it, "" for other lines; None where too few are alike."""
    written = sum(not line.isspace() for line in lines if line)
    sample = [_row(line) for line in [line for line in lines if line.strip()][written // 2 :][:SAMPLE]]
    shapes = Counter(row[0] for row in sample if row is not None)
    shape, count = shapes.most_common(1)[0] if shapes else ((False, (), ()), 0)
    clock, labels, units = shape
    if count < ALIKE * len(sample) or not (clock or any(labels) or any(units)):
        return None
    todo = "cut it, or export it as a plain table"
    require_few(path, len(lines), MAX_SENTENCES, "lines with labels or units in them", todo)
    rows = [row[1] if (row := _row(line)) is not None and row[0] == shape else "" for line in lines]
    return (shape, rows) if sum(map(bool, rows)) >= ALIKE * written else None


def _all_named(shape: _Shape) -> bool:
    """Check whether every number of a row has a label, or without any labels every one a unit."""
    _, labels, units = shape
    return all(labels) or (not any(labels) and all(units))


def _row(line: str) -> tuple[_Shape, str] | None:
    """Return the shape of a line, and its numbers between tabs; None where it holds anything else."""
    arrow = _ARROW.match(line)
    at, items = (arrow.end() if arrow else 0), []
    line = line.rstrip()
    while at < len(line):
        item = _ITEM.match(line, at)
        if item is None or (item[3] and parse_unit(item[3]) is None):
            return None
        items.append(item)
        at = item.end()
    if not items:
        return None
    labels, units = tuple((item[1] or "").strip() for item in items), tuple(item[3] or "" for item in items)
    clock = [arrow[1].replace(",", ".")] if arrow else []
    return (bool(arrow), labels, units), "\t".join([*clock, *(item[2] for item in items)])
