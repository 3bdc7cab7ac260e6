"""How a text file is written: its encoding, its delimiter, its decimal sign, and where its numbers begin."""

import codecs
import csv
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO, TextIOWrapper
from itertools import accumulate
from math import isnan
from pathlib import Path

from daq.importing import recipe
from daq.importing.errors import MAX_LINES, MAX_TEXT, problem, require_few, require_size
from daq.importing.numbers import parse_cell

BLANK = " "
COMMENTS = ("#", "%", "//", "!", "'", "*")
DELIMITERS = (";", "\t", ",", "|", BLANK)
NAMES = {";": "semicolon", "\t": "tab", ",": "comma", "|": "bar", BLANK: "blank"}
MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"),
)  # fmt: skip
_SAMPLE_LINES = 300
_SAMPLE_REST = 100
_SAMPLE_CHARACTERS = 800_000
_RUN = 3
_ODD = tuple(bytes([code]) for code in range(32) if code not in (9, 10, 11, 12, 13, 26, 27, 30, 31))


@dataclass(frozen=True)
class Dialect:
    """Delimiter and decimal sign, the first line of numbers (0-based), and how many cells a row has."""

    delimiter: str
    decimal: str
    start: int
    width: int


def decode(path: Path, data: bytes, encoding: str | None) -> tuple[list[str], str]:
    """Return the lines of a text and a sentence about its encoding ("" when there is nothing to say).

    Raises ImportProblem when it is not text, or more than is read.
    """
    require_size(path, len(data), MAX_TEXT, " of text")
    require_few(path, max(data.count(b"\n"), data.count(b"\r")), MAX_LINES, "lines")
    marked = next((name for mark, name in MARKS if data.startswith(mark)), None)
    name = encoding or marked or "utf-8"
    if name.startswith("utf-8") and sum(map(data.count, _ODD)) > 3 + len(data) // 1000:
        raise problem(
            path, "is not text, nor a MATLAB or UFF file that can be read",
            "name its encoding, as --encoding utf-16-le, or export the recording as CSV and import that",
        )  # fmt: skip
    try:
        said = f"the text was read as {name}{', as asked' if encoding else ''}"
        return _lines(data, name), said if not name.startswith("utf-8") or encoding else ""
    except (LookupError, UnicodeError, ValueError) as error:
        if name != "utf-8" or encoding:
            todo = "name another encoding, or save it again as text"
            raise problem(path, f"cannot be read as {name} ({error})", todo) from None
    said = "the text is no UTF-8, so it was read as cp1252 (Western Europe)"
    todo = "where letters are wrong, name another, as --encoding cp1250 (Central Europe)"
    return _lines(data, "cp1252", "replace"), f"{said}; {todo}"


def _lines(data: bytes, encoding: str, errors: str = "strict") -> list[str]:
    """Return the lines of a text one by one, so that the whole of it is never there a second time."""
    text = TextIOWrapper(BytesIO(data), encoding, errors, newline=None)
    lines = [line.rstrip("\n").replace("\x1a", "").replace("\0", "") for line in text]
    return [*lines, ""] if data.endswith((b"\n", b"\r")) else lines


def split(line: str, delimiter: str) -> list[str]:
    """Return the cells of one line; quotes protect delimiters."""
    if delimiter == BLANK:
        return line.replace('"', "").split()
    if '"' not in line:
        return line.split(delimiter)
    try:
        return next(csv.reader([line], delimiter=delimiter), [])
    except csv.Error:
        return line.split(delimiter)


def is_comment(line: str) -> bool:
    """Check whether a line is a remark."""
    return line.lstrip().startswith(COMMENTS)


def _row_width(line: str, delimiter: str, decimal: str, *, mixed: bool) -> int:
    """Count the cells of a line that begins a row of numbers, 0 for any other line; in a `mixed` table, where some column
    holds text, two numbers are enough.
    """
    if is_comment(line) or not line.strip():
        return 0
    cells = split(line, delimiter)
    found = [parse_cell(cell, decimal) for cell in cells[:64]]
    numbers = sum(number is not None and not isnan(number) for number in found)
    return len(cells) if (numbers >= 2 if mixed else numbers and None not in found) else 0


def _candidates(wanted: recipe.Dialect, lines: Sequence[str]) -> list[tuple[str, str]]:
    """Return delimiters and decimal signs to try; of the delimiters that no line holds one is enough."""
    present = [d for d in DELIMITERS if d == BLANK or any(d in line for line in lines)]
    absent = [d for d in DELIMITERS if d not in present]
    delimiters = (wanted.delimiter,) if wanted.delimiter else (*present, *absent[:1])
    decimals = (wanted.decimal_char,) if wanted.decimal_char else (".", ",")
    free = wanted.delimiter is None or wanted.decimal_char is not None
    return [(d, s) for d in delimiters for s in decimals if free or d != s]


def _sample(lines: Sequence[str]) -> list[int]:
    """Return the numbers of the lines to look at: the first few hundred that are not blank, and some of the rest."""
    written = [i for i, line in enumerate(lines) if line.strip()]
    step = max(1, len(written) // _SAMPLE_REST)
    picked = [*written[:_SAMPLE_LINES], *written[_SAMPLE_LINES::step]]
    sizes = accumulate(len(lines[i]) for i in picked)
    return [i for i, size in zip(picked, sizes, strict=True) if size < _SAMPLE_CHARACTERS] or picked[:1]


def find_dialect(path: Path, lines: Sequence[str], wanted: recipe.Dialect) -> Dialect:
    """Choose the way to cut the lines: try every way and keep the one that gives most numbers.

    Raises ImportProblem when there are no rows of numbers.
    """
    picked = _sample(lines)
    for mixed in (False, True):
        best: tuple[tuple[float, ...], Dialect] | None = None
        for delimiter, decimal in _candidates(wanted, [lines[i] for i in picked]):
            widths = [_row_width(lines[i], delimiter, decimal, mixed=mixed) for i in picked]
            start = _start(widths)
            if start is None:
                continue
            rows = widths[start:]
            width, count = Counter(w for w in rows if w).most_common(1)[0]
            above = split(lines[picked[start - 1]], delimiter) if start else []
            agrees = float(len(above) == width)
            score = (
                round(count / len(rows), 1),
                float(width > 1),
                agrees,
                count / len(rows),
                -DELIMITERS.index(delimiter) if delimiter in DELIMITERS else 0.0,
            )
            if best is None or score > best[0]:
                best = (score, Dialect(delimiter, decimal, picked[start], width))
        if best is not None:
            return best[1]
    if not picked:
        raise problem(path, "holds no rows", "record again or name another file")
    text = " ".join(lines[picked[-1]].split())[:40]
    raise problem(
        path,
        f"no rows of numbers were found; '{text}' is none",
        "export the recording as a table of numbers with one header row, or give the delimiter and the decimal sign",
        line=picked[-1] + 1,
    )


def _start(widths: Sequence[int]) -> int | None:
    """Return the first of three rows of numbers in a row (or of what there is at the end of a short file)."""
    for i, width in enumerate(widths):
        run = widths[i : i + _RUN]
        if width and all(run) and len(set(run)) <= 2 and (len(run) == _RUN or i + len(run) == len(widths)):
            return i
    return None
