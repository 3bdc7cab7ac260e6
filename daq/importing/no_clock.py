"""Time stamps that make no clock: what is wrong with them, and what to do."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from daq.importing.errors import ImportProblem, place
from daq.importing.recipe import Part
from daq.importing.stamps import even_part
from daq.importing.table import SourceColumn, Table
from daq.recording import Array

USE_RATE = "leave the stamps out by giving the rate with --rate"
OFTEN_EQUAL = 0.25
"""Share of stamps equal to the one before, from which on no curve can be drawn through the readings at their stamps."""

NEARLY_ALL = 0.75
"""Share of the rows in the part with a clock from which on the rest is left out without being asked."""


class NoClock(ImportProblem):
    """Stamps that make no clock; `remedy` are the fields of a recipe that would settle it, `certain` where it need not be
    confirmed.
    """

    def __init__(
        self, where: str, sentence: str, remedy: Mapping[str, Any], *, certain: bool = False
    ) -> None:
        super().__init__(f"{where}: {sentence}")
        self.sentence, self.remedy, self.certain = sentence, remedy, certain


def no_clock(
    table: Table,
    column: SourceColumn,
    stamped: tuple[Array, NDArray[np.int64], float],
    worst: int,
    line: tuple[float, float],
) -> NoClock:
    """Return the refusal of stamps that stray from a clock, another where a part of them does not.

    `stamped` are times (s) from the first one, the rows that have them, and the file's own time of the first; `worst` is
    the row that strays most, and `line` the interval of the nearest even clock and the rms of the stray (s).
    """
    time, rows, first = stamped
    found = even_part(time)
    if found is not None:
        start, stop, rates = found
        edge = stop if start == 0 else start
        at = first + float(time[stop - 1] if start == 0 else time[start])
        option, rest = ("to", "after") if start == 0 else ("from", "before")
        share = (stop - start) / len(time)
        return NoClock(
            place(table.path, table.line(int(rows[edge])), column.number),
            f"the time stamps change from a clock of {rates[0]:.3g} Hz to one of {rates[1]:.3g} Hz here; "
            f"--{option} {at:.10g} leaves out what is {rest} that time of the file, "
            f"{100.0 * (1.0 - share):.2g} % of the rows",
            {"parts": (Part.model_validate({option: at}),)}, certain=share > NEARLY_ALL,
        )  # fmt: skip
    slope, stray = line
    what = (
        f"the time stamps stray by {milli(stray)} rms from an even clock of {1 / slope:.6g} Hz, "
        f"{100 * stray / slope:.0f} % of a sampling interval"
    )
    todo = f"put the samples on an even clock with --resample; or {USE_RATE}"
    remedy: dict[str, Any] = {"resample": True}
    if np.mean(np.diff(time) == 0.0) >= OFTEN_EQUAL:
        what += ", and many are equal to the one before"
        todo, remedy = f"if the rows were read evenly, {USE_RATE}", {"rate": float(f"{1 / slope:.6g}")}
    return NoClock(place(table.path, table.line(worst), column.number), f"{what}; {todo}", remedy)


def milli(seconds: float) -> str:
    """Return a time in words, in milliseconds."""
    return f"{seconds * 1e3:.3g} ms"
