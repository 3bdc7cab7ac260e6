"""The lines above the numbers of a text table: names, units, and what they say of the rate and of the unit."""

import re
from collections.abc import Sequence

from daq.importing.columns import meaning
from daq.importing.dialect import BLANK, COMMENTS, Dialect, is_comment, split
from daq.importing.numbers import parse_number
from daq.importing.rates import rate_in
from daq.importing.units import parse_unit

_WORD = re.compile(r"[^\W\d_][^\W_]{0,7}(?:[/*]\(?[^\W\d_][^\W_]{0,3}(?:\^?[-\d]{0,2}))?|°(?:/s)?")
MOST_UNITS = 100
LOGGED = ("...", "\N{HORIZONTAL ELLIPSIS}", "!")
"""So a line of a log ends, and no row of names."""

REMARKS = ("comment", "comments", "remark", "remarks", "notes", "kommentar")


def headers(lines: Sequence[str], dialect: Dialect, width: int) -> tuple[list[str], list[str]]:
    """Return the header and the unit of each column from the lines above the numbers, "" where there is none.

    Of several lines that could be the header, that one is taken whose cells say most; the nearest of equals.
    """
    above: list[list[str]] = []
    for number in range(max(0, dialect.start - 60), dialect.start):
        line = lines[number]
        if not line.strip() or line.rstrip().endswith(LOGGED):
            continue
        if width == 1 and rate_in(line[:300], dialect.decimal) is not None:
            continue
        above.append(_cells_of(line, dialect, width))
    fitting = [cells for cells in above if _fits(cells, width)]
    if not fitting:
        return [""] * width, [""] * width
    rows = [cells for cells in fitting if _is_unit_row(cells)]
    units = _padded(rows[-1], width) if rows else [""] * width
    fitting = [cells for cells in fitting if cells not in rows]
    if not fitting:
        return units, [""] * width
    best = max(range(len(fitting)), key=lambda k: (_says(fitting[k]) if width > 1 else 0, k))
    return _padded(fitting[best], width), units


def _cells_of(line: str, dialect: Dialect, width: int) -> list[str]:
    bare = line.lstrip().lstrip("".join(COMMENTS)).strip() if is_comment(line) else line
    return [c.strip().strip('"').strip() for c in _header_cells(bare, dialect.delimiter, width)]


def _says(cells: Sequence[str]) -> int:
    """Count the different quantities that the cells of a line name."""
    return len({meaning(cell).quantity for cell in cells} - {None})


def _header_cells(line: str, delimiter: str, width: int) -> list[str]:
    """Cut a header line; between blanks `Time (s)` is one cell. Above a table of tabs, too, names may lie between blanks."""
    blanks = delimiter == BLANK or (delimiter == "\t" and delimiter not in line.strip())
    plain = split(line.strip() if blanks else line, delimiter)
    if not blanks or len(plain) == width:
        return plain
    for form in (r"\s{2,}|\t", r"\s+(?![\[(/])"):
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
    words = (
        word
        for line in lines[max(0, dialect.start - 60) : dialect.start]
        for word in _WORD.findall(line[:1000])
    )
    return tuple(sorted({word for word in words if parse_unit(word) is not None}))[:MOST_UNITS]


def rate_above(lines: Sequence[str], dialect: Dialect) -> tuple[float | None, str]:
    """Return the sampling rate that the lines above the table name, and the line, or None."""
    for i, line in enumerate(lines[: min(dialect.start, 200)]):
        rate = rate_in(line[:300], dialect.decimal)
        if rate is not None:
            return rate, f"line {i + 1}"
    return None, ""
