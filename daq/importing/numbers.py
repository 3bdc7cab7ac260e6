"""Numbers, empty cells, times of day and sampling rates as people's files hold them."""

import math
import re
from collections.abc import Mapping, Sequence
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
_NUMBER = r"([-+]?\d[\d.]*(?:[,.]\d+)?(?:[eE][-+]?\d+)?)"
_RATE_NAMES = (
    r"sampl\w*[\s_-]*(?:rate|freq\w*)|samplerate|abtastrate|abtastfrequenz|fr[eé]quence\s+d.[eé]chantillonnage|"
    r"frecuencia\s+de\s+muestreo|frequenza\s+di\s+campionamento|frame[\s_-]*rate|bildrate|\bfps\b|\bfs\b"
)
_STEP_NAMES = (
    r"sampl\w*[\s_-]*(?:interval|period|time|step)|abtastintervall|abtastzeit|time[\s_-]*step|zeitschritt|"
    r"\bdt\b|\bts\b|\bdelta[\s_-]?[tx]\b"
)
_RATE = re.compile(rf"(?:{_RATE_NAMES})\W*?{_NUMBER}\s*(k?Hz)?", re.I)
_BARE_RATE = re.compile(rf"(?<![a-z])(?:rate|freq\w*)\W*?{_NUMBER}\s*(k?Hz|S/s|samples/s|fps)", re.I)
_FRAMES = re.compile(rf"{_NUMBER}\s*(?:fps|frames\s*(?:/|per)\s*s(?:ec\w*)?)(?![a-z])", re.I)
_STEP = re.compile(rf"(?:{_STEP_NAMES})\W*?{_NUMBER}\s*\(?\s*(s|sec\w*|ms|us|µs)?(?![a-z])", re.I)
_ALONE = re.compile(rf"\W*{_NUMBER}\s*(k?Hz|S/s|sps)\W*", re.I)
_RATE_SETTING = re.compile(
    rf"(?:{_RATE_NAMES}|rate|actual_?rate|f_?samp(?:le)?|sr)(?:[\s_-]*\(?k?hz\)?)?", re.I
)
_STEP_SETTING = re.compile(
    rf"(?:{_STEP_NAMES}|tsample|time[\s_-]*(?:interval|period))(?:[\s_-]*\(?m?s\)?)?", re.I
)
LONGEST_STEP = 10.0  # s; a larger number is a date, or the hour of the day
_STEP_SCALE = {"ms": 1e-3, "us": 1e-6, "µs": 1e-6}


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


def parse_cell(text: str, decimal: str = ".") -> float | None:
    """Return a number as `parse_number` does, or a time of day as `parse_clock` does, None for anything else."""
    number = parse_number(text, decimal)
    return parse_clock(text) if number is None else number


@dataclass(frozen=True, eq=False)
class Parsed:
    """The numbers of one column of text: NaN where there is none, and row and text of the first cell that is neither."""

    values: Array
    bad: tuple[int, str] | None = None
    clock: bool = False


def parse_column(cells: Sequence[str], decimal: str) -> Parsed:
    """Return the numbers of a column of text cells."""
    values = np.full(len(cells), math.nan)
    bad: tuple[int, str] | None = None
    clocks = wrong = 0
    for i, cell in enumerate(cells):
        number = parse_cell(cell, decimal)
        clocks += number is not None and ":" in cell
        if number is None:
            bad = bad or (i, cell)
            wrong += 1
            if wrong > ENOUGH:
                break
            continue
        values[i] = number
    return Parsed(values, bad, clocks > len(cells) // 2)


def rate_in(line: str, decimal: str) -> float | None:
    """Return the sampling rate (Hz) that a line of text names, or None."""
    for form in (_RATE, _BARE_RATE, _FRAMES, _STEP, _ALONE):
        match = form.fullmatch(line) if form is _ALONE else form.search(line)
        number = parse_number(match[1], "," if decimal == "," else ".") if match else None
        if match is None or number is None or not 0.0 < number < 1e9:
            continue
        unit = (match[2] or "").lower() if form is not _FRAMES else ""
        if form is _STEP:
            step = number * _STEP_SCALE.get(unit, 1.0)
            if step > LONGEST_STEP or line[match.end(1) : match.end(1) + 1] in (":", "-", "/"):
                continue
            return 1.0 / step
        return number * (1e3 if unit == "khz" else 1.0)
    return None


def rate_of(settings: Mapping[str, float | str]) -> tuple[float | None, str]:
    """Return the sampling rate (Hz) among named settings, and which it is; None and "" where there is none."""
    for whole, value in settings.items():
        number = parse_number(value) if isinstance(value, str) else value
        name = whole.rpartition(".")[2].strip().lower()
        if number is None or isinstance(number, bool) or not 0.0 < number < 1e9:
            continue
        if _RATE_SETTING.fullmatch(name):
            return float(number) * (1e3 if "khz" in name else 1.0), f"'{whole}'"
        if _STEP_SETTING.fullmatch(name):
            step = float(number) * (1e-3 if name.endswith(("ms", "ms)")) else 1.0)
            return 1.0 / step, f"'{whole}' (a sampling interval of {step:g} s)"
    return None, ""
