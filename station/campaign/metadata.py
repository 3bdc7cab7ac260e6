"""Facts about each test besides its record: numbers from the sessions, and from the operator's table."""

import csv
import io
import math
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from station.exits import UsageProblem
from station.suggestions import read_named

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
    text = read_named(file, "the metadata", LARGEST).decode("utf-8-sig", errors="replace")
    first = text.partition("\n")[0]
    table = csv.DictReader(io.StringIO(text), delimiter=max(";\t,", key=first.count), skipinitialspace=True)
    try:
        rows = list(table)
    except csv.Error as error:
        raise UsageProblem(f"the metadata {file} are no table: {error}") from error
    lowered = {name.strip().lower(): name for name in table.fieldnames or ()}
    name_column = lowered.get(SESSION) or lowered.get(FILE)
    if name_column is None:
        raise UsageProblem(
            f"the metadata {file}: no column is called session or file; the first line names the columns"
        )
    found: dict[str, Known] = {}
    texts: dict[str, None] = {}
    for line, row in enumerate(rows, start=2):
        numbers: dict[str, float] = {}
        date = None
        for key, value in row.items():
            column, cell = (key or "").strip(), (value or "").strip() if isinstance(value, str) else ""
            if column.lower() in (SESSION, FILE) or not cell or not column:
                continue
            if column.lower() == DATE:
                date = _date(cell, file, line)
            elif (number := _number(cell)) is not None:
                numbers[column] = number
            else:
                texts[column] = None
        if name := (row[name_column] or "").strip():
            found[name] = Known(date, numbers)
    notes = tuple(f"{file.name}: {column} holds text: no trend is computed for it" for column in texts)
    return found, notes


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
