"""Text of a serial monitor: `13:05:23.417 -> Distance: 12.3 cm`, `angle:1.25,ref:0`, and cells such as `24.4 cm`.

What stands beside the numbers, their labels and units, is the same in each row.
"""

import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from daq.importing.limits import LONGEST_NAME, MAX_SENTENCES, require_few
from daq.importing.recipe import Format
from daq.importing.units import parse_unit

_NUMBER = re.compile(
    r"(?<![\w.])(\d{1,2}:\d\d:\d\d(?:[.,]\d++)?(?= *->)|[-+]?(?:\d++\.?\d*+|\.\d++)(?:[eE][-+]?\d++)?)"
)
_BETWEEN = re.compile(
    r"\s?([^\W\d_][\w/^²]{0,7}|°|%)?\s*(?:[,;|]\s*|->\s*)?"  # the unit of the number before
    r"(?:([^\W\d_](?:[\w ./()\[\]°²^-]{0,30}[\w)\]°])?)\s*[:=]\s*)?"  # the label of the one behind
)
_COMMA = re.compile(r"(?<=\d),(?=\d)")

SAMPLE = 40
ALIKE = 0.9
"""Share of the lines that must have the same labels and units: others are greetings of the board, or were cut off."""

_Names = list[tuple[str, str]]
"""Label and unit of each number of a row."""


def table_of(path: Path, lines: Sequence[str], decimal: str | None) -> tuple[Format, list[str], str] | None:
    """Return the lines as a table between tabs with a header, and a sentence on it; None where they are no such text.

    Each line stays in its place; what does not fit is blank. Where no line is free above the first row, the header comes
    before all. A comma between two digits is the decimal sign where `decimal` says so, or every number then has a label, or
    every one a unit.
    """
    found = None
    if decimal != ".":
        found = _alike(path, [_COMMA.sub(".", line) for line in lines])
        if found is not None and decimal is None and not _all_named(found[0]):
            found = None
    if found is None and decimal != ",":
        found = _alike(path, lines)
    if found is None:
        return None
    names, rows = found
    header = "\t".join(f"{name} ({unit})" if name and unit else name or unit for name, unit in names)
    first = next(i for i, row in enumerate(rows) if row)
    made = [header, *rows] if first == 0 else [*rows[: first - 1], header, *rows[first:]]
    return "serial", made, "what stands beside the numbers in each row was read: times, labels or units"


def _alike(path: Path, lines: Sequence[str]) -> tuple[_Names, list[str]] | None:
    """Return the names of the commonest kind of row and the rows of that kind, "" for other lines; None for too few."""
    written = [line for line in lines if line and not line.isspace()]
    sample = Counter(_split(line)[0] for line in written[len(written) // 2 :][:SAMPLE])
    beside, count = sample.most_common(1)[0] if sample else ((), 0)
    names = _names(beside) if count >= ALIKE * sample.total() else None
    if names is None or not any(name or unit for name, unit in names):
        return None
    todo = "cut it, or export it as a plain table"
    require_few(path, len(lines), MAX_SENTENCES, "lines with labels or units in them", todo)
    rows = [row if found == beside else "" for found, row in map(_split, lines)]
    return (names, rows) if sum(map(bool, rows)) >= ALIKE * len(written) else None


def _split(line: str) -> tuple[tuple[str, ...], str]:
    """Return what stands beside the numbers of a line, each blank as one, and its numbers between tabs."""
    parts = _NUMBER.split(line.strip())
    return tuple(" ".join(part.split()) for part in parts[::2]), "\t".join(parts[1::2])


def _names(beside: Sequence[str]) -> _Names | None:
    """Return the label and the unit of each number from what stands around them; None where that is anything else."""
    found = [_BETWEEN.fullmatch(text) if len(text) <= LONGEST_NAME else None for text in beside]
    gaps = [(match[2] or "", match[1] or "") for match in found if match is not None]
    if len(gaps) < max(len(beside), 2) or gaps[0][1] or gaps[-1][0]:
        return None
    if any(unit and parse_unit(unit) is None for _, unit in gaps):
        return None
    names = [(label, unit) for (label, _), (_, unit) in zip(gaps[:-1], gaps[1:], strict=True)]
    return [("time", ""), *names[1:]] if beside[1].startswith("->") else names


def _all_named(names: _Names) -> bool:
    """Check whether every number but a time of day has a label, or without any labels every one a unit."""
    labels, units = zip(*(names[1:] if names[0] == ("time", "") else names), strict=True)
    return all(labels) or (not any(labels) and all(units))
