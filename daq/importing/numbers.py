"""Numbers, empty cells, dates and times of day as people's files hold them."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np

from daq.recording import Array

MISSING = frozenset(
    {
        "", "nan", "na", "n/a", "#n/a", "#nv", "#na", "null", "none", "nil", "-", "--", "---", "?", "*",
        "+nan", "-nan", "1.#qnan", "-1.#ind", "#div/0!", "#value!", "over", "under", "ovld", "ovl", "missing",
        "inf", "+inf", "-inf", "infinity", "-infinity", "+infinity", "∞", "-∞",
    }
)  # fmt: skip
ENOUGH = 20  # wrong cells, to know that a column is text
_PLAIN = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d{1,4})?")
_GROUPED_DOT = re.compile(
    r"[-+]?[1-9]\d{0,2}(?:(?:[, '\u00a0\u202f]\d{3})+\.\d+|(?:[, '\u00a0\u202f]\d{3}){2,})"
)
_GROUPED_COMMA = re.compile(
    r"[-+]?[1-9]\d{0,2}(?:(?:[. '\u00a0\u202f]\d{3})+,\d+|(?:[. '\u00a0\u202f]\d{3}){2,})"
)
_TIME_OF_DAY = re.compile(r"(?:(\d{1,4}):)?(\d{1,2}):(\d{1,2}(?:[.,]\d{1,9})?)")
_DATE = re.compile(
    r"(?:(?P<y>\d{4})[-/.](?P<m>\d{1,2})[-/.](?P<d>\d{1,2})|(?P<d2>\d{1,2})(?P<sep>[-/.])(?P<m2>\d{1,2})[-/.](?P<y2>\d{4}))"
    r"[T ]\s*(?P<clock>\d{1,2}:\d{1,2}:\d{1,2}(?:[.,]\d{1,9})?)\s*(?:Z|[-+]\d\d:?\d\d)?"
)


def parse_number(text: str, decimal: str = ".") -> float | None:
    """Return the number that `text` spells, NaN for an empty or missing one, None for anything else.

    Thousands may be grouped by the other sign, a blank or an apostrophe where this cannot be mistaken for a
    decimal sign (`1.234,5`, `1,234,567`); Fortran's D exponent and the minus of typesetters are read.
    """
    text = text.strip().strip('"').strip()
    if text.lower() in MISSING:
        return math.nan
    if len(text) > 60:
        return None
    text = text.replace("−", "-")
    plain = text.replace(",", ".") if decimal == "," and "." not in text else text
    if _PLAIN.fullmatch(plain):
        return float(plain.replace("D", "e").replace("d", "e"))
    grouped = _GROUPED_COMMA if decimal == "," else _GROUPED_DOT
    if grouped.fullmatch(text):
        digits = re.sub(r"[ '\u00a0\u202f]", "", text)
        digits = digits.replace(".", "").replace(",", ".") if decimal == "," else digits.replace(",", "")
        return float(digits)
    return None


def parse_clock(text: str) -> float | None:
    """Return the seconds of a time of day (`12:34:56,789`, `3:25.5`) or of a date and time, else None."""
    text = text.strip().strip('"').strip()
    if len(text) > 40 or ":" not in text:
        return None
    match = _TIME_OF_DAY.fullmatch(text)
    if match:
        return _seconds(match)
    match = _DATE.fullmatch(text)
    if not match:
        return None
    year = int(match["y"] or match["y2"])
    month, day = int(match["m"] or match["m2"]), int(match["d"] or match["d2"])
    if (match["sep"] == "/" and day <= 12) or month > 12:
        month, day = day, month
    clock = _TIME_OF_DAY.fullmatch(match["clock"])
    try:
        midnight = datetime(year, month, day, tzinfo=UTC).timestamp()
    except (ValueError, OverflowError):
        return None
    return None if clock is None else midnight + _seconds(clock)


def _seconds(match: re.Match[str]) -> float:
    hours = int(match[1] or 0)
    return 3600.0 * hours + 60.0 * int(match[2]) + float(match[3].replace(",", "."))


@dataclass(frozen=True, eq=False)
class Parsed:
    """The numbers of one column of text: NaN where there is none, the row of the first cell that is neither."""

    values: Array
    bad: int | None = None
    clock: bool = False


def parse_column(cells: Sequence[str], decimal: str) -> Parsed:
    """Return the numbers of a column of text cells."""
    values = np.full(len(cells), math.nan)
    bad: int | None = None
    clocks = wrong = 0
    for i, cell in enumerate(cells):
        number = parse_number(cell, decimal)
        if number is None:
            number = parse_clock(cell)
            clocks += number is not None
        if number is None:
            bad = i if bad is None else bad
            wrong += 1
            if wrong > ENOUGH:
                break
            continue
        values[i] = number
    return Parsed(values, bad, clocks > len(cells) // 2)
