"""Time stamps that make no clock: what is wrong with them, and what to do."""

import numpy as np
from numpy.typing import NDArray

from daq.importing.errors import ImportProblem, problem
from daq.importing.rate_change import rate_change
from daq.importing.table import SourceColumn, Table
from daq.recording import Array

USE_RATE = "leave the stamps out by giving the rate with --rate"
OFTEN_EQUAL = 0.25
"""Share of stamps equal to the one before, from which on no curve can be drawn through the readings at their stamps."""


def no_clock(
    table: Table,
    column: SourceColumn,
    stamped: tuple[Array, NDArray[np.int64], float],
    worst: int,
    line: tuple[float, float],
) -> ImportProblem:
    """Return the refusal of stamps that stray from a clock; what to do is another where the logger changed its rate.

    `stamped` are times (s) from the first one, the rows that have them, and the file's own time of the first; `worst` is
    the row that strays most, and `line` the interval of the nearest even clock and the rms of the stray (s).
    """
    time, rows, first = stamped
    change = rate_change(time)
    if change is not None:
        before = change.row >= len(time) - change.row
        at = first + float(time[change.row - 1 if before else change.row])
        part = f"--{'to' if before else 'from'} {at:.10g}"
        return problem(
            table.path,
            f"the rate of the time stamps changes here from {change.before:.3g} to {change.after:.3g} Hz",
            f"read the {'first' if before else 'last'} part with {part}", options=(part,),
            line=table.line(int(rows[change.row])), column=column.number,
        )  # fmt: skip
    slope, stray = line
    what = (
        f"the time stamps stray by {milli(stray)} rms from an even clock of {1 / slope:.6g} Hz, "
        f"{100 * stray / slope:.0f} % of a sampling interval"
    )
    todo, option = f"put the samples on an even clock with --resample; or {USE_RATE}", "--resample"
    if np.mean(np.diff(time) == 0.0) >= OFTEN_EQUAL:
        what += ", and many are equal to the one before"
        todo, option = f"if the rows were read evenly, {USE_RATE}", "--rate HZ"
    return problem(table.path, what, todo, line=table.line(worst), column=column.number, options=(option,))


def milli(seconds: float) -> str:
    """Return a time in words, in milliseconds."""
    return f"{seconds * 1e3:.3g} ms"
