"""Text of a serial monitor: `13:05:23.417 -> Distance: 12.3 cm`, `angle:1.25,ref:0`, and cells such as `24.4 cm`."""

import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from daq.importing.limits import MAX_SENTENCES, require_few
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


class _Row(NamedTuple):
    clock: str
    labels: tuple[str, ...]
    units: tuple[str, ...]
    numbers: tuple[str, ...]

    @property
    def shape(self) -> tuple[bool, tuple[str, ...], tuple[str, ...]]:
        return bool(self.clock), self.labels, self.units


def table_of(path: Path, lines: Sequence[str], decimal: str | None) -> tuple[Format, list[str], str] | None:
    """Return the lines as a table between tabs with a header, and a sentence on it; None where they are no such text.

    Each line stays in its place; what does not fit is blank. Where no line is free above the first row, the header comes
    before all. A comma between two digits is the decimal sign where `decimal` says so, or every number then has a label, or
    every one a unit.
    """
    rows = _alike(path, lines) if decimal != "," else None
    if decimal == "," or (decimal is None and rows is not None and not _all_named(rows)):
        del rows  # both at once would be too much
        rows = _alike(path, [_COMMA.sub(".", line) for line in lines])
        if decimal is None and (rows is None or not _all_named(rows)):
            rows = _alike(path, lines)
    if rows is None:
        return None
    first, row = next((i, row) for i, row in enumerate(rows) if row is not None)
    clock, labels, units = row.shape
    cells = [
        f"{name} ({unit})" if name and unit else name or unit
        for name, unit in zip(labels, units, strict=True)
    ]
    header = "\t".join([*(["time"] if clock else []), *cells])
    made = ["" if row is None else "\t".join([*([row.clock] if clock else []), *row.numbers]) for row in rows]
    made = [header, *made] if first == 0 else [*made[: first - 1], header, *made[first:]]
    return "serial", made, "what stands beside the numbers in each row was read: times, labels or units"


def _alike(path: Path, lines: Sequence[str]) -> list[_Row | None] | None:
    """Return the rows that have the commonest labels and units, None for other lines; None where too few are alike."""
    written = [line for line in lines if line.strip()]
    middle = len(written) // 2
    sample = [_row(line) for line in written[middle : middle + SAMPLE]]
    shapes = Counter(row.shape for row in sample if row is not None)
    if not shapes:
        return None
    ((shape, count),) = shapes.most_common(1)
    clock, labels, units = shape
    if count < ALIKE * len(sample) or not (clock or any(labels) or any(units)):
        return None
    require_few(
        path,
        len(lines),
        MAX_SENTENCES,
        "lines with labels or units in them",
        "cut it, or export it as a plain table",
    )
    rows = [row if (row := _row(line)) is not None and row.shape == shape else None for line in lines]
    return rows if sum(row is not None for row in rows) >= ALIKE * len(written) else None


def _all_named(rows: Sequence[_Row | None]) -> bool:
    """Check whether every number of a row has a label, or without any labels every one a unit."""
    row = next(row for row in rows if row is not None)
    return all(row.labels) or (not any(row.labels) and all(row.units))


def _row(line: str) -> _Row | None:
    """Return the numbers of a line with their labels and units; None where it holds anything else."""
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
    return _Row(
        arrow[1].replace(",", ".") if arrow else "",
        tuple((item[1] or "").strip() for item in items),
        tuple(item[3] or "" for item in items),
        tuple(item[2] for item in items),
    )
