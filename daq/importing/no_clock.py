"""Time stamps that make no clock, or are not there: what is wrong, and what to do."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from daq.importing.errors import ImportProblem, place
from daq.importing.table import SourceColumn, Table
from daq.recording import Array

USE_RATE = "leave the stamps out by giving the rate with --rate"
OFTEN_EQUAL = 0.25
"""Share of stamps equal to the one before, from which on no curve can be drawn through the readings at their stamps."""

FEWEST_IN_A_RUN = 50


class NoClock(ImportProblem):
    """Stamps that make no clock; `remedy` are the fields of a recipe that would settle it, none where only the operator
    can say it; `done` says what was done where it need not be confirmed.
    """

    def __init__(self, where: str, sentence: str, remedy: Mapping[str, Any], done: str = "") -> None:
        super().__init__(f"{where}: {sentence}")
        self.remedy, self.done = remedy, done


def begins_again(table: Table, column: SourceColumn, time: Array, rows: NDArray[np.int64]) -> ImportProblem:
    """Return the refusal of stamps that fall: where they always fall to the first one, the rows are runs."""
    back = np.flatnonzero(np.diff(time) < 0.0) + 1
    alike = np.abs(time[back] - time[0]) <= 2.0 * np.median(np.abs(np.diff(time)))
    long = np.diff([0, *back, len(time)]) >= FEWEST_IN_A_RUN
    where = place(table.path, table.line(int(rows[back[0]])), column.number)
    what = f"the time stamp jumps back from {time[back[0] - 1]:.6g} s to {time[back[0]]:.6g} s"
    if alike.all() and long.all():
        done = f"{what}{table.at(rows[back[0]])}: the rows were cut where it does"
        return NoClock(where, what, {"restarts": True}, done)
    todo = (
        "say in a recipe that the rows restart there (restarts = true), or that these are steps (time_step)"
    )
    return ImportProblem(f"{where}: {what}; {todo}; or {USE_RATE}")


def no_clock(where: str, time: Array, slope: float, stray: float) -> NoClock:
    """Return the refusal of stamps (s) that stray by this rms (s) from the nearest even clock, of interval `slope` (s)."""
    what = strays(stray, slope)
    todo = f"put the samples on an even clock with --resample; or {USE_RATE}"
    remedy: dict[str, Any] = {"resample": True}
    if np.mean(np.diff(time) == 0.0) >= OFTEN_EQUAL:
        what += ", and many are equal to the one before"
        todo, remedy = f"if the rows were read evenly, {USE_RATE}", {"rate": float(f"{1 / slope:.6g}")}
    return NoClock(where, f"{what}; {todo}", remedy)


def strays(stray: float, slope: float) -> str:
    """Say by how much stamps stray (rms, s) from an even clock of this interval (s)."""
    return (
        f"the time stamps stray by {1e3 * stray:.3g} ms rms from an even clock of {1.0 / slope:.6g} Hz "
        f"({100.0 * stray / slope:.3g} % of a sampling interval)"
    )
