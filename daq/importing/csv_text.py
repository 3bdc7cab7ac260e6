"""Text tables as people have them: any delimiter, decimal comma, headers, units, remarks, holes."""

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from daq.importing import serial_text
from daq.importing.column_numbers import counts_rows
from daq.importing.columns import meaning
from daq.importing.dialect import BLANK, COMMENTS, NAMES, Dialect, decode, find_dialect, is_comment, split
from daq.importing.errors import LONGEST_LINE, problem, require_few, require_table
from daq.importing.numbers import Parsed, parse_cell, parse_column, parse_number, rate_in
from daq.importing.recipe import Recipe
from daq.importing.table import SourceColumn, Table
from daq.importing.units import parse_unit
from daq.recording import Array

AT_ONCE = 1_000_000
"""Cells of a table with holes that are there as text at a time."""

_WORD = re.compile(r"[^\W\d_][^\W_]{0,7}(?:[/*]\(?[^\W\d_][^\W_]{0,3}(?:\^?[-\d]{0,2}))?|°(?:/s)?")
MOST_UNITS = 100
LOGGED = ("...", "\N{HORIZONTAL ELLIPSIS}", "!")
"""So a line of a log ends, and no row of names."""

REMARKS = ("comment", "comments", "remark", "remarks", "notes", "kommentar")


def read_csv(path: Path, data: bytes, recipe: Recipe) -> Table:
    """Return the table in a text file. Raises ImportProblem with line and column when there is none."""
    wanted = recipe.dialect
    lines, said = decode(path, data, recipe.encoding)
    for number, line in enumerate(lines, start=1):
        require_few(path, len(line), LONGEST_LINE, "characters", "write one sample per line", number)
    blank = set(wanted.comment_rows)
    if max(blank, default=0) >= len(lines):
        raise problem(path, f"has {len(lines)} lines", f"skip fewer rows than {max(blank)}")
    lines = ["" if number in blank else line for number, line in enumerate(lines, start=1)]
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
    fast = _all_at_once([lines[i] for i in rows], dialect)
    if fast is not None:
        parsed = [Parsed(column) for column in fast.T]
    else:
        parsed, rows = _cell_by_cell(path, lines, rows, dialect, notes)
    names, units = [""] * len(parsed), [""] * len(parsed)
    if wanted.header:
        counted = len(parsed) > 1 and counts_rows(parsed[0].values, any_step=True)
        names, units = headers(lines, dialect, len(parsed), counted=counted)
    if not names[-1] and names[0] and counts_rows(parsed[0].values):
        names = ["row", *names[:-1]]
    columns = []
    for i, column in enumerate(parsed):
        if not names[i] and not units[i] and column.bad is None and not np.isfinite(column.values).any():
            continue
        bad = None if column.bad is None else (rows[column.bad[0]] + 1, column.bad[1].strip()[:30])
        columns.append(SourceColumn(i + 1, names[i], column.values, units[i], bad=bad, clock=column.clock))
    sign = "decimal comma" if dialect.decimal == "," else "decimal point"
    name = NAMES.get(dialect.delimiter, f"'{dialect.delimiter}'")
    layout = f"{len(rows)} rows from line {rows[0] + 1}, {len(columns)} columns"
    notes.insert(0, f"text table: {layout}, delimiter {name}, {sign}")
    rate, source = rate_above(lines, dialect)
    used = {"delimiter": dialect.delimiter, "decimal_char": dialect.decimal} if odd is None else {}
    return Table(
        path, tuple(columns), np.array(rows, dtype=np.int64) + 1, rate, source, tuple(notes),
        format=format, encoding=recipe.encoding, stated=units_above(lines, dialect), dialect=wanted.model_copy(update=used),
    )  # fmt: skip


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
    """Return columns and their lines of a table with holes, remarks, quotes, text or lines of uneven length."""
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
    numbers = [parse_cell(cell, decimal) for cell in cells]
    return None not in numbers or any(number is not None and not math.isnan(number) for number in numbers)


def headers(
    lines: Sequence[str], dialect: Dialect, width: int, *, counted: bool = False
) -> tuple[list[str], list[str]]:
    """Return the header and the unit of each column from the lines above the numbers, "" where there is none.

    Of several lines that could be the header, that one is taken whose cells say most; the nearest of equals. A "#" that
    stands alone above a column that counts rows (`counted`) is its name, and no remark.
    """
    above: list[list[str]] = []
    for number in range(max(0, dialect.start - 60), dialect.start):
        line = lines[number]
        if not line.strip() or line.rstrip().endswith(LOGGED):
            continue
        if width == 1 and rate_in(line[:300], dialect.decimal) is not None:
            continue
        cells = _header_cells(line, dialect.delimiter, width)
        if is_comment(line) and not (counted and len(cells) == width and cells[0].strip() == "#"):
            cells = _header_cells(line.lstrip().lstrip("".join(COMMENTS)).strip(), dialect.delimiter, width)
        above.append([c.strip().strip('"').strip() for c in cells])
    fitting = [cells for cells in above if _fits(cells, width)]
    units = [cells for cells in fitting if _is_unit_row(cells)]
    names = [cells for cells in fitting if cells not in units]
    if not names:
        names, units = units[-1:], []
    says = [_says(cells) if width > 1 else 0 for cells in names]
    best = max(range(len(names)), key=lambda k: (says[k], k), default=0)
    return _padded(names[best] if names else (), width), _padded(units[-1] if units else (), width)


def _says(cells: Sequence[str]) -> int:
    """Count the different quantities that the cells of a line name."""
    return len({meaning(cell).quantity for cell in cells} - {None})


def _header_cells(line: str, delimiter: str, width: int) -> list[str]:
    """Cut a header line; between blanks `Time (s)` is one cell. Above tabs, too, names may lie between blanks, or commas."""
    blanks = delimiter == BLANK or (delimiter == "\t" and delimiter not in line.strip())
    plain = split(line.strip() if blanks else line, delimiter)
    if not blanks or len(plain) == width:
        return plain
    for form in (r"\s{2,}|\t", r"\s+(?![\[(/])", ","):
        cells = re.split(form, line.strip())
        if len(cells) == width and (delimiter == BLANK or _says(cells)):
            return cells
    return plain


def _fits(cells: Sequence[str], width: int) -> bool:
    """Check whether cells can be names of the columns: enough of them, and none but the first a number."""
    named = [i for i, cell in enumerate(cells) if cell and cell.lower() not in REMARKS]
    if not named or named[-1] >= width or any(_is_number(cell) for cell in cells[1:]):
        return False
    return len(cells) >= width - 1 or len(named) == width


def _is_number(cell: str) -> bool:
    plain = bool(cell) and not cell[0].isalpha()
    return plain and any(parse_number(cell, decimal) is not None for decimal in ".,")


def _padded(cells: Sequence[str], width: int) -> list[str]:
    return [*cells, *[""] * width][:width]


def _is_unit_row(cells: Sequence[str]) -> bool:
    """Check whether every cell is a unit, in brackets or bare, one at least; the first may say what the row holds."""
    bare = [cell.strip("()[] ") for cell in cells]
    known = [parse_unit(cell) is not None for cell in bare if cell not in ("", "-", "1")]
    bracketed = all(cell[0] in "([" and cell[-1] in ")]" for cell in cells if cell)
    return bool(known) and (all(known) or (bracketed and any(known)) or (len(known) > 1 and all(known[1:])))


def units_above(lines: Sequence[str], dialect: Dialect) -> tuple[str, ...]:
    """Return the units that the lines above the table name, in the order of the alphabet."""
    found = (
        word
        for line in lines[max(0, dialect.start - 60) : dialect.start]
        for word in _WORD.findall(line[:1000])
    )
    return tuple(sorted({word for word in found if parse_unit(word) is not None}))[:MOST_UNITS]


def rate_above(lines: Sequence[str], dialect: Dialect) -> tuple[float | None, str]:
    """Return the sampling rate that the lines above the table name, and the line, or None."""
    for number, line in enumerate(lines[: min(dialect.start, 200)], start=1):
        if (rate := rate_in(line[:300], dialect.decimal)) is not None:
            return rate, f"line {number}"
    return None, ""
