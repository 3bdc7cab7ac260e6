"""Time stamps that make no clock, or are not there: what is wrong, and what to do."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from daq.importing.errors import ImportProblem, place
from daq.importing.recipe import Part, Recipe
from daq.importing.table import SourceColumn, Table
from daq.recording import Array

USE_RATE = "leave the stamps out by giving the rate with --rate"
OFTEN_EQUAL = 0.25
"""Share of stamps equal to the one before, from which on no curve can be drawn through the readings at their stamps."""

NEARLY_ALL = 0.75
"""Share of the rows before or after a gap from which on the rest is left out without being asked."""

FEWEST_IN_A_RUN = 50


class NoClock(ImportProblem):
    """Stamps that make no clock; `remedy` are the fields of a recipe that would settle it, none where only the operator
    can say it, `certain` where it need not be confirmed; `done` says what was done.
    """

    def __init__(
        self, where: str, sentence: str, remedy: Mapping[str, Any], done: str = "", *, certain: bool = False
    ) -> None:
        super().__init__(f"{where}: {sentence}")
        self.remedy, self.done, self.certain = remedy, done, certain

    def mended(self, recipe: Recipe) -> Recipe:
        """Return a recipe with the remedy; of its own parts, one alone, only an end that is open is moved."""
        fields = dict(self.remedy)
        if recipe.parts and (left := fields.pop("parts", ())) and len(recipe.parts) == 1:
            fields["parts"] = (left[0].model_copy(update=recipe.parts[0].model_dump(exclude_none=True)),)
        return recipe.model_copy(update=fields)


def begins_again(table: Table, column: SourceColumn, time: Array, rows: NDArray[np.int64]) -> ImportProblem:
    """Return the refusal of stamps that fall: where they always fall to the first one, the rows are runs."""
    back = np.flatnonzero(np.diff(time) < 0.0) + 1
    alike = np.abs(time[back] - time[0]) <= 2.0 * np.median(np.abs(np.diff(time)))
    long = np.diff([0, *back, len(time)]) >= FEWEST_IN_A_RUN
    where = place(table.path, table.line(int(rows[back[0]])), column.number)
    what = f"the time stamp jumps back from {time[back[0] - 1]:.6g} s to {time[back[0]]:.6g} s"
    if alike.all() and long.all():
        done = f"{what}{table.at(rows[back[0]])}: the rows were cut where it does"
        return NoClock(where, what, {"restarts": True}, done, certain=True)
    todo = (
        "say in a recipe that the rows restart there (restarts = true), or that these are steps (time_step)"
    )
    return ImportProblem(f"{where}: {what}; {todo}; or {USE_RATE}")


def no_clock(
    table: Table,
    column: SourceColumn,
    stamped: tuple[Array, NDArray[np.int64], float],
    gap: int | None,
    worst: int,
    line: tuple[float, float],
) -> NoClock:
    """Return the refusal of stamps that stray from a clock, another where the larger part of them, up to or from a `gap`,
    does not.

    `stamped` are times (s) from the first one, the rows that have them, and the file's own time of the first; `worst` is
    the row that strays most, and `line` the interval of the nearest even clock and the rms of the stray (s).
    """
    time, rows, first = stamped
    if gap is not None:
        before = 2 * gap >= len(time)
        option, rest, at = ("to", "after", gap - 1) if before else ("from", "before", gap)
        share = max(gap, len(time) - gap) / len(time)
        rows_left, end = f"{100.0 * (1.0 - share):.2g} % of the rows", f"{first + time[at]:.10g}"
        what = "the time stamps go on by another clock after a gap"
        return NoClock(
            place(table.path, table.line(int(rows[gap])), column.number),
            f"{what} here; --{option} {end} leaves out what is {rest} that time of the file, {rows_left}",
            {"parts": (Part.model_validate({option: first + float(time[at])}),)},
            f"{what}{table.at(rows[gap])}: what is {rest} {end} s of the file, {rows_left}, was left out "
            "(--resample keeps it)", certain=share > NEARLY_ALL,
        )  # fmt: skip
    slope, stray = line
    what = strays(stray, slope)
    todo = f"put the samples on an even clock with --resample; or {USE_RATE}"
    remedy: dict[str, Any] = {"resample": True}
    if np.mean(np.diff(time) == 0.0) >= OFTEN_EQUAL:
        what += ", and many are equal to the one before"
        todo, remedy = f"if the rows were read evenly, {USE_RATE}", {"rate": float(f"{1 / slope:.6g}")}
    return NoClock(place(table.path, table.line(worst), column.number), f"{what}; {todo}", remedy)


def strays(stray: float, slope: float) -> str:
    """Say by how much stamps stray (rms, s) from an even clock of this interval (s)."""
    return (
        f"the time stamps stray by {1e3 * stray:.3g} ms rms from an even clock of {1.0 / slope:.6g} Hz "
        f"({100.0 * stray / slope:.3g} % of a sampling interval)"
    )
