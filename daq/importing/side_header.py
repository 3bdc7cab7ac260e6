"""An oscilloscope's table: what was set stands in columns to the left of the first rows, the numbers to the right of it."""

from collections.abc import Sequence
from pathlib import Path

from daq.importing.limits import MAX_CELLS, require_few
from daq.importing.numbers import parse_number

FEWEST_ROWS = 20
MOST_SETTINGS = 200
WIDEST = 8


def table_of(path: Path, lines: Sequence[str]) -> tuple[list[str], str] | None:
    """Return the lines as a table with a header, and a sentence on it; None where no settings stand beside the numbers.

    The header comes before all lines:

        Record Length,2500,,-0.10000,1.62,
        Sample Interval,4e-05,,-0.09996,1.64,
        Source,CH1,,-0.09992,1.60,
        ,,,-0.09988,1.58,
    """
    last = next((line for line in reversed(lines) if line.strip()), "")
    if not last.startswith(",,"):
        return None
    require_few(path, sum(line.count(",") for line in lines), MAX_CELLS, "cells")
    rows = [line.split(",") for line in lines if line.strip()]
    width = _width(rows)
    if not width:
        return None
    named = sum(bool(row[0].strip()) for row in rows)
    texts = sum(parse_number(row[0]) is None for row in rows[:named])
    count = next((k for k, cell in enumerate(rows[-1][width:]) if not cell.strip()), len(rows[-1]) - width)
    beside = all(_is_number(cell) for row in rows for cell in row[width : width + count])
    apart = not any(cell.strip() for row in rows[MOST_SETTINGS:] for cell in row[:width])
    if not 3 <= texts <= MOST_SETTINGS or not beside or not apart:
        return None
    facts = {row[0].strip().lower(): row[1].strip() for row in rows[:MOST_SETTINGS]}
    units = facts.get("horizontal units", "s"), facts.get("vertical units", "")
    name = facts.get("source", "signal")
    unit = f" ({units[1]})" if units[1] else ""
    channels = [f"{name}{unit}"] if count == 2 else [f"{name} {k}{unit}" for k in range(1, count)]
    header = ",".join([f"time ({units[0]})", *channels])
    made = [",".join(line.split(",")[width : width + count]) if line.strip() else "" for line in lines]
    return [header, *made], f"what an oscilloscope was set to stands beside the first {named} rows"


def _is_number(cell: str) -> bool:
    number = parse_number(cell)
    return number is not None and number == number


def _width(rows: Sequence[Sequence[str]]) -> int:
    """Return how many columns the settings have: those that are blank in the last rows; 0 where none are."""
    if len(rows) < FEWEST_ROWS or min(len(row) for row in rows) < 4:
        return 0
    blank = [next((i for i, cell in enumerate(row) if cell.strip()), len(row)) for row in rows[-3:]]
    width = blank[0]
    fits = len(set(blank)) == 1 and 2 <= width <= WIDEST and min(len(row) for row in rows) >= width + 2
    return width if fits else 0
