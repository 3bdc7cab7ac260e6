"""Text tables as people have them: any delimiter, decimal comma, headers, units, remarks, holes."""

import csv
import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from daq.importing.dialect import BLANK, COMMENTS, NAMES, Dialect, decode, find_dialect, is_comment, split
from daq.importing.errors import problem
from daq.importing.numbers import Parsed, parse_column, parse_number
from daq.importing.options import ImportOptions
from daq.importing.table import SourceColumn, Table
from daq.importing.units import parse_unit
from daq.recording import Array

MAX_COLUMNS = 2000
_RATE_WORDS = re.compile(
    r"(?:sampl\w*[\s_-]*(?:rate|freq\w*)|samplerate|abtastrate|abtastfrequenz|fr[eé]quence\s+d.[eé]chantillonnage|"
    r"frecuencia\s+de\s+muestreo|frequenza\s+di\s+campionamento|\bfs\b)\W*?([-+]?\d[\d.]*(?:[,.]\d+)?(?:[eE][-+]?\d+)?)\s*(k?Hz)?",
    re.I,
)


def read_csv(path: Path, data: bytes, options: ImportOptions) -> Table:
    """Return the table in a text file. Raises ImportProblem with line and column when there is none."""
    text, said = decode(path, data, options.encoding)
    lines = text.split("\n")
    del text
    if options.skip_rows >= len(lines):
        raise problem(path, f"has {len(lines)} lines", f"skip fewer rows than {options.skip_rows}")
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
    parsed, rows = _numbers(path, lines, rows, dialect, notes)
    headers, units = _headers(lines, dialect, options.skip_rows, len(parsed))
    if headers and not headers[-1] and headers[0] and _counts(parsed[0]):
        headers = ["row", *headers[:-1]]
    columns = []
    for i, column in enumerate(parsed):
        if not headers[i] and not units[i] and column.bad is None and not np.isfinite(column.values).any():
            continue
        bad = None
        if column.bad is not None:
            row = rows[column.bad]
            cells = split(lines[row], dialect.delimiter)
            bad = (row + 1, cells[i].strip()[:30] if i < len(cells) else "")
        columns.append(SourceColumn(i + 1, headers[i], column.values, units[i], bad=bad, clock=column.clock))
    sign = "decimal comma" if dialect.decimal == "," else "decimal point"
    name = NAMES.get(dialect.delimiter, f"'{dialect.delimiter}'")
    layout = f"{len(rows)} rows from line {rows[0] + 1}, {len(columns)} columns" if rows else "no rows"
    notes.insert(0, f"text table: {layout}, delimiter {name}, {sign}")
    rate, source = _rate_above(lines, dialect)
    return Table(path, tuple(columns), np.array(rows, dtype=np.int64) + 1, rate, source, tuple(notes))


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
            f"{len(remarks)} lines between the rows are remarks and were left out, first line {remarks[0] + 1}"
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


def _headers(lines: Sequence[str], dialect: Dialect, skip: int, width: int) -> tuple[list[str], list[str]]:
    """Return the header and the unit of each column from the lines above the numbers, "" where there is none."""
    above = []
    for line in lines[max(skip, dialect.start - 60) : dialect.start]:
        if not line.strip():
            continue
        if is_comment(line):
            line = line.lstrip().lstrip("".join(COMMENTS)).strip()
        above.append([c.strip().strip('"').strip() for c in _header_cells(line, dialect.delimiter, width)])
    fitting = [cells for cells in above if _fits(cells, width)]
    if not fitting:
        return [""] * width, [""] * width
    units = [""] * width
    header = fitting.pop()
    if _is_unit_row(header):
        units = _padded(header, width)
        if not fitting:
            return units, [""] * width
        header = fitting.pop()
    return _padded(header, width), units


def _header_cells(line: str, delimiter: str, width: int) -> list[str]:
    """Cut a header line; between blanks `Time (s)` is one cell."""
    if delimiter != BLANK or len(split(line, delimiter)) == width:
        return split(line, delimiter)
    for form in (r"\s{2,}|\t", r"\s+(?![\[(/])"):
        cells = re.split(form, line.strip())
        if len(cells) == width:
            return cells
    return split(line, delimiter)


def _fits(cells: Sequence[str], width: int) -> bool:
    named = [i for i, cell in enumerate(cells) if cell]
    if not named or named[-1] >= width:
        return False
    return len(cells) >= width - 1 or len(named) == width


def _padded(cells: Sequence[str], width: int) -> list[str]:
    return [*cells, *[""] * width][:width]


def _is_unit_row(cells: Sequence[str]) -> bool:
    """Return whether every cell is a unit, in brackets or bare, and at least one is."""
    bare = [cell.strip("()[] ") for cell in cells]
    known = [parse_unit(cell) is not None for cell in bare if cell not in ("", "-", "1")]
    bracketed = all(cell[0] in "([" and cell[-1] in ")]" for cell in cells if cell)
    return bool(known) and (all(known) or (bracketed and any(known)))


def _rate_above(lines: Sequence[str], dialect: Dialect) -> tuple[float | None, str]:
    """Return the sampling rate that the lines above the table name, and the line, or None."""
    for i, line in enumerate(lines[: min(dialect.start, 200)]):
        match = _RATE_WORDS.search(line[:300])
        if match:
            number = parse_number(match[1], "," if dialect.decimal == "," else ".")
            if number is not None and 0.0 < number < 1e9:
                return number * (1e3 if (match[2] or "").lower() == "khz" else 1.0), f"line {i + 1}"
    return None, ""
