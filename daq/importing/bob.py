"""The angle of a pendulum from x and y of its bob."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from daq.importing.columns import meaning, split_unit, words
from daq.importing.errors import problem
from daq.importing.options import NONE, ImportOptions
from daq.importing.still import amplitude, is_measurable
from daq.importing.table import SourceColumn, Table
from daq.recording import Array

ROUND = 0.03
"""A radius that is constant to 3 % is that of a pendulum."""

SMALLEST_ARC = 0.02  # rad, rms: below it a circle cannot be told from a line
LARGE_ARC = 0.1  # rad, rms: 8 degrees of swing, whose sagitta is a hundredth of the length
CLOSE = 0.003
"""So closely, as a share of the radius, an arc is kept that is found without being asked for: a third of that sagitta."""
FEWEST = 8


def with_angle(table: Table, options: ImportOptions) -> Table:
    """Return the table with an angle in the place of the columns x and y of a bob.

    The angle is `atan2(x, -y)`, zero where the bob hangs, with y upwards from the pivot; where y counts downwards, as
    in a picture, `atan2(x, y)`. The columns are those that the operator names, or else the only two that could be a
    displacement, if they lie on an arc about the pivot: the origin, or where they are called x and y the centre of the
    circle that fits, if the arc is large and closely kept. Raises ImportProblem where the columns that are named do
    not lie on an arc.
    """
    if options.angle_from is not None:
        x, y = (_named(table, wanted) for wanted in options.angle_from)
        measurable = is_measurable(x.values) and is_measurable(y.values)
        pivot = _pivot(x.values, y.values) if measurable else None
        if pivot is None:
            raise problem(
                table.path, f"{x.place} and {y.place} do not lie on an arc",
                "name the bob's x and y, or one column with --column displacement=...",
            )  # fmt: skip
        return _replaced(table, x, y, pivot, "as asked")
    pair = _pair(table, options)
    if pair is None:
        return table
    if _on_arc(pair[0].values, pair[1].values, (0.0, 0.0)):
        why = "they lie on an arc about their origin; --column displacement=... takes one"
        return _replaced(table, *pair, (0.0, 0.0), why)
    pivot = _pivot_elsewhere(*pair)
    if pivot is None:
        return table
    return _replaced(table, *pair, pivot, "they lie on an arc; --column displacement=... takes one")


def _named(table: Table, wanted: str) -> SourceColumn:
    text = str(wanted).strip()
    found = [c for c in table.columns if c.label == text] or [
        c
        for c in table.columns
        if str(c.number) == text or split_unit(c.label)[0].casefold() == text.casefold()
    ]
    if len(found) != 1:
        listed = ", ".join(c.place for c in table.columns[:8])
        raise problem(
            table.path, f"there is no one column '{text}'; the file has {listed}", "give its number"
        )
    return found[0]


def _pair(table: Table, options: ImportOptions) -> tuple[SourceColumn, SourceColumn] | None:
    """Return the columns that could be x and y: two called so, or, without names, two beside the time."""
    if any(
        q in options.columns and options.columns[q] != NONE
        for q in ("displacement", "velocity", "acceleration")
    ):
        return None
    numbers = [c for c in table.columns if c.bad is None and is_measurable(c.values)]
    said = {c.number: meaning(c.label, c.unit) for c in numbers}
    if any(
        said[c.number].angular or c.quantity in ("displacement", "velocity", "acceleration") for c in numbers
    ):
        return None
    x = [c for c in numbers if "x" in words(split_unit(c.label)[0])]
    y = [c for c in numbers if "y" in words(split_unit(c.label)[0])]
    if len(x) == len(y) == 1:
        return x[0], y[0]
    nameless = [c for c in numbers if not c.label and c.quantity is None]
    if len(numbers) == 3 and len(nameless) >= 2:
        return nameless[-2], nameless[-1]
    return None


def on_an_arc(x: SourceColumn, y: SourceColumn) -> bool:
    """Return whether two columns lie on a large arc about the origin or another centre, if only roughly."""
    measurable = is_measurable(x.values) and is_measurable(y.values)
    return measurable and _large_arc(x, y) is not None


def _pivot_elsewhere(x: SourceColumn, y: SourceColumn) -> tuple[float, float] | None:
    """Return the centre of a large, closely kept arc of columns called x and y, as video tracking writes them, or None."""
    pivot = _large_arc(x, y) if x.label and y.label else None
    if pivot is None:
        return None
    radius = np.hypot(x.values - pivot[0], y.values - pivot[1])
    return pivot if amplitude(radius) < CLOSE * float(np.nanmean(radius)) else None


def _large_arc(x: SourceColumn, y: SourceColumn) -> tuple[float, float] | None:
    pivot = _pivot(x.values, y.values)
    if pivot is None:
        return None
    angle = _angle(x.values, y.values, pivot)[0]
    return pivot if amplitude(angle) > LARGE_ARC and np.nanmax(np.abs(angle)) < np.pi else None


def _pivot(x: Array, y: Array) -> tuple[float, float] | None:
    """Return the centre of the arc: the origin, or else the centre of the circle that fits (Kasa 1976), or None."""
    if _on_arc(x, y, (0.0, 0.0)):
        return 0.0, 0.0
    there = np.isfinite(x) & np.isfinite(y)
    a, b = x[there], y[there]
    if len(a) < FEWEST:
        return None
    matrix = np.column_stack([2.0 * (a - a.mean()), 2.0 * (b - b.mean()), np.ones(len(a))])
    u, v, _ = np.linalg.lstsq(matrix, (a - a.mean()) ** 2 + (b - b.mean()) ** 2, rcond=None)[0]
    centre = float(u + a.mean()), float(v + b.mean())
    return centre if _on_arc(x, y, centre) else None


def _on_arc(x: Array, y: Array, centre: tuple[float, float]) -> bool:
    radius = np.hypot(x - centre[0], y - centre[1])
    radius = radius[np.isfinite(radius)]
    if len(radius) < FEWEST or not 0.0 < float(np.mean(radius)) < 1e100:
        return False
    arc = amplitude(_angle(x, y, centre)[0])
    return amplitude(radius) < ROUND * min(float(np.mean(radius)), 3.0 * amplitude(x)) and arc > SMALLEST_ARC


def _angle(x: Array, y: Array, centre: tuple[float, float]) -> tuple[Array, bool]:
    """Return the angle (rad) and whether y counts upwards."""
    across, up = x - centre[0], y - centre[1]
    upwards = float(np.nanmedian(up)) < 0.0
    angle = np.arctan2(across, -up if upwards else up)
    there = np.isfinite(angle)
    angle[there] = np.unwrap(angle[there])
    return angle, upwards


def _replaced(table: Table, x: SourceColumn, y: SourceColumn, pivot: tuple[float, float], why: str) -> Table:
    angle, upwards = _angle(x.values, y.values, pivot)
    formula = f"atan2(x, {'-y' if upwards else 'y'})"
    about = "" if pivot == (0.0, 0.0) else f" about the pivot at x = {pivot[0]:.4g}, y = {pivot[1]:.4g}"
    length = float(np.nanmean(np.hypot(x.values - pivot[0], y.values - pivot[1])))
    note = f"x in {x.place} and y in {y.place} give the angle {formula}{about}, radius {length:.4g}: {why}"
    made = replace(x, label="angle", values=angle, unit="rad", quantity="displacement")
    columns: Sequence[SourceColumn] = [made if c is x else c for c in table.columns if c is not y]
    return replace(table, columns=tuple(columns), notes=(*table.notes, note))
