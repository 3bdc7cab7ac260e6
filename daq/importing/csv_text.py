"""Text tables as people have them: any delimiter, decimal comma, headers, units, remarks, holes."""

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from daq.importing import serial_text
from daq.importing.column_numbers import counts_rows
from daq.importing.dialect import BLANK, NAMES, Dialect, decode, find_dialect, is_comment, split
from daq.importing.errors import problem
from daq.importing.header_lines import headers, rate_above, units_above
from daq.importing.limits import require_lines, require_table
from daq.importing.numbers import Parsed, parse_column, parse_number
from daq.importing.recipe import Dialect as WantedDialect, Recipe
from daq.importing.table import SourceColumn, Table
from daq.recording import Array

AT_ONCE = 1_000_000
"""Cells of a table with holes that are there as text at a time."""


def read_csv(path: Path, data: bytes, recipe: Recipe) -> Table:
    """Return the table in a text file. Raises ImportProblem with line and column when there is none."""
    wanted = recipe.dialect
    lines, said = decode(path, data, recipe.encoding)
    require_lines(path, lines)
    lines = _without_comments(path, lines, wanted)
    odd = None
    if recipe.format != "text" and wanted.delimiter is None:
        odd = serial_text.table_of(path, lines, wanted.decimal_char)
    format, lines, how = odd if odd is not None else ("text", lines, "")
    dialect = find_dialect(path, lines, wanted)
    if not wanted.header:
        dialect = replace(dialect, start=0)
    rows = [i for i in range(dialect.start, len(lines)) if lines[i] and not lines[i].isspace()]
    require_table(path, len(rows), dialect.width)
    notes = [text for text in (said, how) if text]
    parsed, rows = _numbers(path, lines, rows, dialect, notes)
    names, units = [""] * len(parsed), [""] * len(parsed)
    if wanted.header:
        names, units = headers(lines, dialect, len(parsed))
    if names and not names[-1] and names[0] and counts_rows(parsed[0].values):
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
    used = {"delimiter": dialect.delimiter, "decimal_char": dialect.decimal} if odd is None else {}
    return Table(
        path, tuple(columns), np.array(rows, dtype=np.int64) + 1, rate, source, tuple(notes),
        format=format, encoding=recipe.encoding, stated=units_above(lines, dialect), dialect=wanted.model_copy(update=used),
    )  # fmt: skip


def _without_comments(path: Path, lines: list[str], wanted: WantedDialect) -> list[str]:
    """Return the lines, those blank that a recipe names as remarks."""
    if max(wanted.comment_rows, default=0) >= len(lines):
        raise problem(path, f"has {len(lines)} lines", f"skip fewer rows than {max(wanted.comment_rows)}")
    blank = set(wanted.comment_rows)
    return ["" if number in blank else line for number, line in enumerate(lines, start=1)] if blank else lines


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
    if dialect.decimal == dialect.delimiter:
        return None
    lines = (line.replace(",", ".") for line in body) if dialect.decimal == "," else body
    separator = None if dialect.delimiter == BLANK else dialect.delimiter
    try:
        values = np.loadtxt(lines, delimiter=separator, comments=None, ndmin=2, encoding=None)
    except (ValueError, IndexError, OverflowError):
        return None
    return np.asarray(values, dtype=np.float64) if len(values) == len(body) else None


def _cell_by_cell(
    path: Path, lines: list[str], rows: list[int], dialect: Dialect, notes: list[str]
) -> tuple[list[Parsed], list[int]]:
    """Return the columns of a table with holes, remarks, quotes, text or lines of uneven length."""
    cut = dialect.delimiter
    remarks = [i for i in rows if is_comment(lines[i])]
    rows = [i for i in rows if not is_comment(lines[i])]
    if remarks:
        notes.append(
            f"remarks between the rows were left out: {len(remarks)}, the first line {remarks[0] + 1}"
        )
    last = len(rows)
    while len(rows) > 1 and not _has_number(split(lines[rows[-1]], cut), dialect.decimal):
        rows.pop()
    if len(rows) < last:
        notes.append(f"{last - len(rows)} lines at the end hold no numbers and were left out")
    width = max(dialect.width, 1)
    ends_within = len(rows) > 1 and rows[-1] == len(lines) - 1  # no line break: the file was cut off
    if ends_within and len(split(lines[rows[-1]], cut)) < width:
        notes.append(f"line {rows.pop() + 1}, the last, is cut short and was left out")
    lengths = [len(split(lines[i], cut)) for i in rows]
    short = [k for k, n in enumerate(lengths) if n < width]
    long = [
        k
        for k, n in enumerate(lengths)
        if n > width and any(map(str.strip, split(lines[rows[k]], cut)[width:]))
    ]
    if long or len(short) > max(1, len(rows) // 20):
        first, *others = long or short
        raise problem(
            path, f"this row has {lengths[first]} cells where most have {width}"
            + (f", and {len(others)} more are like it" if others else ""),
            "repair the file, or give the delimiter and the decimal sign", line=rows[first] + 1,
        )  # fmt: skip
    if short:
        where = f"first line {rows[short[0]] + 1}"
        notes.append(f"{len(short)} rows are cut short ({where}); their missing cells count as invalid")
    columns: list[Parsed] = []
    several = max(AT_ONCE // len(rows), 1)
    for left in range(0, width, several):
        part = [_cells(lines[i], dialect.delimiter, left, min(left + several, width)) for i in rows]
        columns += [parse_column([row[j] for row in part], dialect.decimal) for j in range(len(part[0]))]
    return columns, rows


def _cells(line: str, delimiter: str, left: int, right: int) -> list[str]:
    """Return the cells of a line from column `left` up to `right`, empty ones where it is cut short."""
    cells = split(line, delimiter)[left:right]
    return cells + [""] * (right - left - len(cells))


def _has_number(cells: Sequence[str], decimal: str) -> bool:
    """Check whether a row holds a number or a time of day, or nothing at all, but no text alone."""
    numbers = [parse_number(cell, decimal) for cell in cells]
    if any(number is not None and not math.isnan(number) for number in numbers):
        return True
    return None not in numbers or any(":" in cell and any(map(str.isdigit, cell)) for cell in cells)
