"""Numbers, empty cells and times of day as people's files hold them."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from daq.recording import Array

MISSING = frozenset(
    {
        "", "nan", "na", "n/a", "#n/a", "#nv", "#na", "null", "none", "nil", "-", "--", "---", "?", "*",
        "+nan", "-nan", "ovf", "1.#qnan", "-1.#ind", "#div/0!", "#value!", "over", "under", "ovld", "ovl", "missing",
        "inf", "+inf", "-inf", "infinity", "-infinity", "+infinity", "∞", "-∞",
    }
)  # fmt: skip
ENOUGH = 20  # wrong cells, to know that a column is text
_PLAIN = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d{1,4})?")
_CLOCK = re.compile(
    r"(?:\d{1,4}([-/.])\d{1,2}\1\d{1,4}[T ]\s*)?(?:(\d{1,4}):)?(\d{1,2}):(\d{1,2}(?:[.,]\d{1,9})?)\s*(?:Z|[-+]\d\d:?\d\d)?"
)


def parse_number(text: str, decimal: str = ".") -> float | None:
    """Return the number that `text` spells, NaN for an empty or missing one, None for anything else.

    Fortran's D exponent and the minus of typesetters are read.
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
    return None


def parse_clock(text: str) -> float | None:
    """Return the seconds of a time of day (`12:34:56,789`, `3:25.5`), behind a date or not, else None."""
    text = text.strip().strip('"').strip()
    match = _CLOCK.fullmatch(text) if len(text) <= 40 and ":" in text else None
    if match is None:
        return None
    return 3600.0 * int(match[2] or 0) + 60.0 * int(match[3]) + float(match[4].replace(",", "."))


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
