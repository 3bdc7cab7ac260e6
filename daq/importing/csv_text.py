"""Text tables as people have them: any delimiter, decimal comma, headers, units, remarks, holes."""

import csv
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from daq.importing import lvm, serial_text, side_header
from daq.importing.dialect import BLANK, COMMENTS, NAMES, Dialect, decode, find_dialect, split
from daq.importing.errors import problem
from daq.importing.header_lines import Setting, headers, motion_unit, rate_above, settings_above
from daq.importing.numbers import Parsed, parse_column, parse_number
from daq.importing.options import ImportOptions
from daq.importing.table import SourceColumn, Table
from daq.recording import Array

MAX_COLUMNS = 2000


def read_csv(path: Path, data: bytes, options: ImportOptions) -> Table:
    """Return the table in a text file. Raises ImportProblem with line and column when there is none."""
    text, said = decode(path, data, options.encoding)
    lines = text.split("\n")
    del text
    if options.skip_rows >= len(lines):
        raise problem(path, f"has {len(lines)} lines", f"skip fewer rows than {options.skip_rows}")
    body = lines[options.skip_rows :]
    odd = None
    if options.delimiter is None:
        odd = lvm.table_of(body) or serial_text.table_of(body) or side_header.table_of(body)
    if odd is not None:
        lines = [*[""] * options.skip_rows, *odd[0]]
    dialect = find_dialect(path, lines, options)
    if dialect.width > MAX_COLUMNS:
        raise problem(
            path,
            f"has {dialect.width} columns, more than {MAX_COLUMNS}",
            "write one sample per line, one channel per column",
            line=dialect.start + 1,
        )
    rows = [i for i in range(dialect.start, len(lines)) if lines[i] and not lines[i].isspace()]
    notes = [said] if said else []
    notes += [odd[1]] if odd is not None else []
    parsed, rows = _numbers(path, lines, rows, dialect, notes)
    names, units = headers(lines, dialect, options.skip_rows, len(parsed))
    if names and not names[-1] and names[0] and _counts(parsed[0]):
        names = ["row", *names[:-1]]
    columns = []
    for i, column in enumerate(parsed):
        if not names[i] and not units[i] and column.bad is None and not np.isfinite(column.values).any():
            continue
        bad = None
        if column.bad is not None:
            row = rows[column.bad]
            cells = split(lines[row], dialect.delimiter)
            bad = (row + 1, cells[i].strip()[:30] if i < len(cells) else "")
        columns.append(SourceColumn(i + 1, names[i], column.values, units[i], bad=bad, clock=column.clock))
    sign = "decimal comma" if dialect.decimal == "," else "decimal point"
    name = NAMES.get(dialect.delimiter, f"'{dialect.delimiter}'")
    layout = f"{len(rows)} rows from line {rows[0] + 1}, {len(columns)} columns" if rows else "no rows"
    notes.insert(0, f"text table: {layout}, delimiter {name}, {sign}")
    rate, source = rate_above(lines, dialect)
    columns = _by_settings(columns, settings_above(lines, dialect), notes)
    return Table(path, tuple(columns), np.array(rows, dtype=np.int64) + 1, rate, source, tuple(notes))


def _by_settings(
    columns: list[SourceColumn], settings: Sequence[Setting], notes: list[str]
) -> list[SourceColumn]:
    """Give a single column without a name the quantity and the unit that the settings above it name."""
    said = motion_unit(settings)
    if said is None or len(columns) != 1 or columns[0].label or columns[0].unit:
        return columns
    quantity, unit, line = said
    notes.append(f"column 1 has no name; line {line - 1} names {unit}: it was taken as {quantity} in {unit}")
    return [replace(columns[0], quantity=quantity, unit=unit)]


def _numbers(
    path: Path, lines: list[str], rows: list[int], dialect: Dialect, notes: list[str]
) -> tuple[list[Parsed], list[int]]:
    """Return the columns and the lines they came from: all at once if the table is clean, else cell by cell."""
    fast = _all_at_once([lines[i] for i in rows], dialect)
    if fast is not None:
        return [Parsed(column) for column in fast.T], rows
    return _cell_by_cell(path, lines, rows, dialect, notes)


def _all_at_once(body: Sequence[str], dialect: Dialect) -> Array | None:
    """Return the numbers of a clean table, shape (rows, columns), or None when some cell needs a closer look."""
    delimiter = dialect.delimiter
    text = "\n".join(body)
    if '"' in text:
        return None
    if dialect.decimal == ",":
        if delimiter == ",":
            return None
        text = text.replace(",", ".")
    if delimiter != BLANK:
        if delimiter * 2 in text:
            text = text.replace(delimiter * 2, f"{delimiter}nan{delimiter}")
            text = text.replace(delimiter * 2, f"{delimiter}nan{delimiter}")
        if f"{delimiter}\n" in text or text.endswith(delimiter):
            text = (text + "\n").replace(f"{delimiter}\n", f"{delimiter}nan\n")
        if f"\n{delimiter}" in text or text.startswith(delimiter):
            text = ("\n" + text).replace(f"\n{delimiter}", f"\nnan{delimiter}")[1:]
    try:
        values = np.loadtxt(
            text.split("\n"),
            delimiter=None if delimiter == BLANK else delimiter,
            comments=None,
            ndmin=2,
            encoding=None,
        )
    except (ValueError, IndexError, OverflowError):
        return None
    return np.asarray(values, dtype=np.float64) if len(values) == len(body) else None


def _cell_by_cell(
    path: Path, lines: list[str], rows: list[int], dialect: Dialect, notes: list[str]
) -> tuple[list[Parsed], list[int]]:
    """Return the columns of a table with holes, remarks, quotes, text or lines of uneven length."""
    remarks = [i for i in rows if lines[i].lstrip().startswith(COMMENTS)]
    if remarks:
        notes.append(
            f"between the rows {_counted(len(remarks), 'line is a remark and was', 'lines are remarks and were')} left out, "
            f"{'the first ' if len(remarks) > 1 else ''}line {remarks[0] + 1}"
        )
        rows = [i for i in rows if not lines[i].lstrip().startswith(COMMENTS)]
    try:
        cells = [split(lines[i], dialect.delimiter) for i in rows]
    except csv.Error as error:
        raise problem(path, f"a quoted cell cannot be read ({error})", "remove the quotes") from None
    footer = 0
    while len(cells) > 1 and not _has_number(cells[-1], dialect.decimal):
        cells.pop()
        rows = rows[:-1]
        footer += 1
    if footer:
        notes.append(f"{footer} lines at the end hold no numbers and were left out")
    width = max(dialect.width, 1)
    short = [k for k, row in enumerate(cells) if len(row) < width]
    for k, row in enumerate(cells):
        if len(row) > width:
            extra = next((j for j in range(width, len(row)) if row[j].strip()), None)
            if extra is not None:
                raise problem(
                    path,
                    f"this row has {len(row)} cells where the others have {width}",
                    "repair the line, or give the delimiter and the decimal sign",
                    line=rows[k] + 1,
                    column=extra + 1,
                )
            del row[width:]
    if short:
        if len(short) > max(1, len(cells) // 20):
            raise problem(
                path,
                f"this row has {len(cells[short[0]])} cells where most have {width}, and {len(short)} rows are like it",
                "repair the file, or give the delimiter and the decimal sign",
                line=rows[short[0]] + 1,
            )
        for k in short:
            cells[k] += [""] * (width - len(cells[k]))
        first = rows[short[0]] + 1
        notes.append(
            f"{len(short)} rows are cut short (first line {first}); their missing cells count as invalid"
        )
    return [parse_column(column, dialect.decimal) for column in zip(*cells, strict=True)], rows


def _counted(number: int, one: str, many: str) -> str:
    return f"{number} {one if number == 1 else many}"


def _counts(column: Parsed) -> bool:
    """Recognise a column of row numbers, which some programs write without a header."""
    values = column.values
    return len(values) > 2 and values[0] in (0.0, 1.0) and bool(np.all(np.diff(values) == 1.0))


def _has_number(cells: Sequence[str], decimal: str) -> bool:
    for cell in cells:
        number = parse_number(cell, decimal)
        if number is not None and not math.isnan(number):
            return True
        if ":" in cell and any(c.isdigit() for c in cell):
            return True
    return False
