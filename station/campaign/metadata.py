"""Facts about each test besides its record: numbers from the sessions, and from the operator's table."""

import csv
import io
import math
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from station.exits import UsageProblem

LARGEST = 50 << 20
SESSION, FILE, DATE = "session", "file", "date"


@dataclass(frozen=True)
class Known:
    """When a test was made, where the table says so, and numbers by name with unit, as "temperature [degC]"."""

    date: datetime | None = None
    conditions: dict[str, float] = field(default_factory=dict)


def read_metadata(file: Path) -> tuple[dict[str, Known], tuple[str, ...]]:
    """Read the operator's table: the facts of each session, by its name or its file's, and notes on unusable columns.

    The table is comma separated, or by semicolons or tabs, with a header; one column is `session` or `file`, another may be
    `date` (as 2026-03-01 or 2026-03-01T14:30), the others are numbers. Raises UsageProblem when it is none of this.
    """
    try:
        content = file.read_bytes()
    except OSError as error:
        raise UsageProblem(f"the metadata {file} cannot be read: {error.strerror or error}") from error
    if len(content) > LARGEST:
        raise UsageProblem(f"the metadata {file} are too large for a table of sessions")
    rows = _rows(content.decode("utf-8-sig", errors="replace"))
    header = [name.strip() for name in rows[0]] if rows else []
    lowered = [name.lower() for name in header]
    name_column = next((lowered.index(name) for name in (SESSION, FILE) if name in lowered), None)
    if name_column is None:
        raise UsageProblem(
            f"the metadata {file}: no column is called session or file; the first line names the columns"
        )
    found: dict[str, Known] = {}
    texts: dict[str, None] = {}
    for number, row in enumerate(rows[1:], start=2):
        cells = dict(zip(header, (cell.strip() for cell in row), strict=False))
        name = cells.get(header[name_column], "")
        numbers: dict[str, float] = {}
        date = None
        for column, cell in cells.items():
            if column.lower() in (SESSION, FILE) or not cell or not column:
                continue
            if column.lower() == DATE:
                date = _date(cell, file, number)
            elif (value := _number(cell)) is not None:
                numbers[column] = value
            else:
                texts[column] = None
        if name:
            found[name] = Known(date, numbers)
    notes = tuple(f"{file.name}: {column} holds text: no trend is computed for it" for column in texts)
    return found, notes


def _rows(text: str) -> list[list[str]]:
    first = text.partition("\n")[0]
    separator = max(";\t,", key=first.count)
    lines = csv.reader(io.StringIO(text), delimiter=separator)
    try:
        return [row for row in lines if any(cell.strip() for cell in row)]
    except csv.Error as error:
        raise UsageProblem(f"the metadata are no table: {error}") from error


def _number(cell: str) -> float | None:
    try:
        value = float(cell if "." in cell else cell.replace(",", "."))
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _date(cell: str, file: Path, number: int) -> datetime:
    try:
        date = datetime.fromisoformat(cell)
    except ValueError as error:
        raise UsageProblem(
            f"the metadata {file}, line {number}: {cell[:40]!r} is no date; write it as 2026-03-01"
        ) from error
    return date if date.tzinfo is not None else date.replace(tzinfo=UTC)
