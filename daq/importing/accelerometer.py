"""Three axes of an accelerometer: known by the gravity in them; the one that moves is taken."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from daq.importing.columns import meaning, split_unit, words
from daq.importing.options import ImportOptions, ask
from daq.importing.still import amplitude, is_measurable
from daq.importing.table import SourceColumn, Table
from daq.importing.units import STANDARD_GRAVITY
from daq.recording import Array

AXES = ("x", "y", "z")
WITHIN = 0.03
"""Gravity is found again to 3 %: the calibration of a phone's accelerometer."""

MOST_SENSORS = 4
STEEPER = 1.3
"""The moving axis moves this much more than the next one."""


def has_gravity(values: Array) -> bool:
    """Return whether the numbers, in m/s^2, swing about plus or minus the acceleration of gravity."""
    finite = values[np.isfinite(values)]
    return bool(len(finite)) and abs(abs(float(np.median(finite))) / STANDARD_GRAVITY - 1.0) < WITHIN


def with_moving_axis(table: Table, options: ImportOptions) -> Table:
    """Return the table with one axis of each three-axis sensor, the other two left out.

    Three columns are such a sensor if the mean of their vector is gravity, or if they are named as the x, y and z of
    an acceleration or a velocity. It is a doubt where no axis moves more than the others.
    """
    if any(q in options.columns for q in ("displacement", "velocity", "acceleration")) or options.angle_from:
        return table
    for _ in range(MOST_SENSORS):
        found = _by_gravity(table) or _by_name(table)
        if found is None:
            break
        table = _with_one_axis(table, *found)
    return table


def _with_one_axis(table: Table, axes: Sequence[SourceColumn], unit: str, gravity: bool) -> Table:
    amplitudes = [amplitude(c.values) for c in axes]
    order = np.argsort(amplitudes)[::-1]
    first, second = axes[int(order[0])], axes[int(order[1])]
    quantity = "acceleration" if gravity else meaning(first.label, first.unit).quantity or "acceleration"
    doubts = table.doubts
    if amplitudes[order[0]] < STEEPER * amplitudes[order[1]]:
        doubts += (
            f"{first.place} and {second.place} are axes of one sensor and move alike; "
            f"choose one, as in {ask(quantity, first.number)}",
        )
    share = 100.0 * amplitudes[order[1]] / amplitudes[order[0]]
    kind, why = (
        ("an accelerometer", "their mean vector is gravity") if gravity else ("a sensor", "by their names")
    )
    note = (
        f"{', '.join(c.place for c in axes)} are the axes of {kind} ({why}); {first.place} moves most "
        f"and was taken as the {quantity} (the next axis moves {share:.0f} % as much)"
    )
    said = first.unit or split_unit(first.label)[1] or unit
    taken = replace(first, quantity=quantity, unit=said, gravity=gravity, label=first.label or quantity)
    rest = {c.number for c in axes} - {first.number}
    columns = tuple(taken if c is first else c for c in table.columns if c.number not in rest)
    return replace(table, columns=columns, notes=(*table.notes, note), doubts=doubts)


def _axis(column: SourceColumn) -> str:
    """Return the axis that a name ends in or stands for ("" for none, "?" for no name at all)."""
    name = words(split_unit(column.label)[0])
    if not name:
        return "?" if not column.label else ""
    last = name[-1]
    if last in AXES:
        return last
    if last[:-1] in ("a", "acc", "accel", "g", "f") and last[-1] in AXES:
        return last[-1]
    return next((w for w in name if w in AXES), "")


def _in_g(axes: Sequence[SourceColumn]) -> bool:
    """Return whether the axes are called `gFx`, `g_y` and the like."""
    return all(words(c.label)[:1] in (("g",), ("gf",), ("gforce",)) for c in axes)


def _triples(table: Table) -> list[Sequence[SourceColumn]]:
    columns = [c for c in table.columns if c.bad is None and is_measurable(c.values)]
    return [columns[i : i + 3] for i in range(len(columns) - 2)]


def _by_gravity(table: Table) -> tuple[Sequence[SourceColumn], str, bool] | None:
    """Return three axes with gravity in them, and the unit where they name none."""
    for three in _triples(table):
        named = [_axis(c) for c in three]
        if not (named == ["?"] * 3 or sorted(named) == list(AXES)):
            continue
        said = [meaning(c.label, c.unit) for c in three]
        if any(s.unit is not None and s.unit.quantity != "acceleration" for s in said):
            continue
        mean = float(np.linalg.norm([np.nanmedian(c.values) for c in three]))
        for scale, unit in ((1.0, "m/s^2"), (STANDARD_GRAVITY, "g")):
            accelerations = unit != "g" or any(s.quantity == "acceleration" for s in said) or _in_g(three)
            if accelerations and abs(mean * scale / STANDARD_GRAVITY - 1.0) < WITHIN:
                return three, unit, True
    return None


def _by_name(table: Table) -> tuple[Sequence[SourceColumn], str, bool] | None:
    for three in _triples(table):
        said = [meaning(c.label, c.unit) for c in three]
        kinds = {s.quantity for s in said}
        if sorted(_axis(c) for c in three) == list(AXES) and kinds in ({"acceleration"}, {"velocity"}):
            return three, "", False
    return None
