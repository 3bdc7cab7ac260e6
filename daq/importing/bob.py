"""The angle of a pendulum from x and y of its bob."""

from dataclasses import replace
from shlex import quote

import numpy as np

from daq.importing.column_numbers import amplitude, is_measurable
from daq.importing.columns import split_unit, words
from daq.importing.errors import problem
from daq.importing.options import ImportOptions, ask
from daq.importing.table import SourceColumn, Table, named
from daq.recording import MOTIONS, Array

ROUND = 0.03
"""A radius that is constant to 3 % is that of a pendulum."""

SMALLEST_ARC = 0.02  # rad, rms: below it a circle is not distinguishable from a line
LARGE_ARC = 0.1  # rad, rms: 8 degrees of swing, whose sagitta is a hundredth of the length
FEWEST = 8


def with_angle(table: Table, options: ImportOptions) -> Table:
    """Return the table with an angle in the place of the columns x and y of a bob.

    The columns are those that the operator names, or else the only two that could be a displacement, if they lie on an
    arc about the pivot: the origin, or the centre of the circle that fits, if the arc is large, which is a doubt. Raises
    ImportProblem where the columns that are named do not lie on an arc.
    """
    if options.angle_from is not None:
        x, y = (named(table, wanted, "angle") for wanted in options.angle_from)
        return _replaced(table, x, y, "as asked")
    pair = _pair(table, options)
    pivot = _pivot(pair[0].values, pair[1].values) if pair is not None else None
    if pair is None or pivot is None:
        return table
    x, y = pair
    made = _replaced(table, x, y, "they lie on an arc; --column displacement=... takes one")
    angle = _angle(x.values, y.values, pivot)[0]
    if pivot == (0.0, 0.0):
        return made
    if amplitude(angle) <= LARGE_ARC or np.nanmax(np.abs(angle)) >= np.pi:
        return table
    names = quote(",".join(split_unit(c.label)[0].strip() or str(c.number) for c in pair))
    doubt = (
        f"2 columns could be the displacement: {x.place}, {y.place}; they lie on an arc: if they are a "
        f"pendulum's bob, its angle is --angle-from {names}, else choose one, as in {ask('displacement', x.number)}"
    )
    return replace(made, doubts=(*table.doubts, doubt))


def angle_of(
    table: Table, x: SourceColumn, y: SourceColumn, pivot: tuple[float, float] | None = None
) -> tuple[SourceColumn, str]:
    """Return the angle (rad) of a bob at x and y, and its formula: `atan2(x, -y)`, zero where it hangs, y upwards from the
    pivot; where y counts downwards, as in a picture, `atan2(x, y)`. Raises ImportProblem where no pivot is given and they
    lie on no arc.
    """
    if pivot is None and is_measurable(x.values) and is_measurable(y.values):
        pivot = _pivot(x.values, y.values)
    if pivot is None:
        raise problem(
            table.path, f"{x.place} and {y.place} do not lie on an arc",
            "name the bob's x and y, or one column with --column displacement=...",
        )  # fmt: skip
    angle, upwards = _angle(x.values, y.values, pivot)
    about = "" if pivot == (0.0, 0.0) else f" about the pivot at x = {pivot[0]:.4g}, y = {pivot[1]:.4g}"
    length = float(np.nanmean(np.hypot(x.values - pivot[0], y.values - pivot[1])))
    formula = f"angle atan2(x, {'-y' if upwards else 'y'}){about}, radius {length:.4g}"
    made = replace(
        x, label="angle", values=angle, unit="rad", quantity="displacement", arc=(x.number, y.number)
    )
    return made, formula


def _pair(table: Table, options: ImportOptions) -> tuple[SourceColumn, SourceColumn] | None:
    """Return the columns that could be x and y: two called so, or, without names, two beside the time."""
    if any(q in options.named for q in MOTIONS):
        return None
    numbers = [c for c in table.columns if c.bad is None and is_measurable(c.values)]
    if any(c.said.angular or c.quantity in MOTIONS for c in numbers):
        return None
    x, y = ([c for c in numbers if axis in words(split_unit(c.label)[0])] for axis in "xy")
    if len(x) == len(y) == 1:
        return x[0], y[0]
    nameless = [c for c in numbers if not c.label and c.quantity is None]
    return (nameless[-2], nameless[-1]) if len(numbers) == 3 and len(nameless) >= 2 else None


def _pivot(x: Array, y: Array) -> tuple[float, float] | None:
    """Return the centre of the arc: the origin, or else that of the circle that fits (Kasa 1976), and better than a line."""
    loose = 3.0 * ROUND * amplitude(x)
    if _on_arc(x, y, (0.0, 0.0), loose):
        return 0.0, 0.0
    there = np.isfinite(x) & np.isfinite(y)
    a, b = x[there], y[there]
    if len(a) < FEWEST:
        return None
    matrix = np.column_stack([2.0 * (a - a.mean()), 2.0 * (b - b.mean()), np.ones(len(a))])
    u, v, _ = np.linalg.lstsq(matrix, (a - a.mean()) ** 2 + (b - b.mean()) ** 2, rcond=None)[0]
    centre = float(u + a.mean()), float(v + b.mean())
    return centre if _on_arc(x, y, centre, min(loose, amplitude(y))) else None


def _on_arc(x: Array, y: Array, centre: tuple[float, float], most: float) -> bool:
    radius = np.hypot(x - centre[0], y - centre[1])
    radius = radius[np.isfinite(radius)]
    if len(radius) < FEWEST or not 0.0 < float(np.mean(radius)) < 1e100:
        return False
    arc = amplitude(_angle(x, y, centre)[0])
    return amplitude(radius) < min(ROUND * float(np.mean(radius)), most) and arc > SMALLEST_ARC


def _angle(x: Array, y: Array, centre: tuple[float, float]) -> tuple[Array, bool]:
    """Return the angle (rad) and whether y counts upwards."""
    across, up = x - centre[0], y - centre[1]
    upwards = float(np.nanmedian(up)) < 0.0
    angle = np.arctan2(across, -up if upwards else up)
    there = np.isfinite(angle)
    angle[there] = np.unwrap(angle[there])
    return angle, upwards


def _replaced(table: Table, x: SourceColumn, y: SourceColumn, why: str) -> Table:
    made, formula = angle_of(table, x, y)
    note = f"x in {x.place} and y in {y.place} give the {formula}: {why}"
    columns = tuple(made if c is x else c for c in table.columns if c is not y)
    return replace(table, columns=columns, notes=(*table.notes, note))
