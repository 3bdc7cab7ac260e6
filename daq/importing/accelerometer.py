"""Three axes of an accelerometer: known by their names or by the gravity in them; the one that moves is taken."""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from daq.importing.columns import meaning, split_unit, words
from daq.importing.options import ImportOptions, ask
from daq.importing.still import amplitude, is_measurable
from daq.importing.table import SourceColumn, Table
from daq.importing.units import STANDARD_GRAVITY
from daq.recording import Array

WITHIN = 0.03
"""Gravity is found again to 3 %: the calibration of a phone's accelerometer."""

MOST_SENSORS = 4
STEEPER = 1.3
"""The moving axis moves this much more than the next one."""

_AXIS = re.compile(r"(?:.* )?(?:a|acc|accel|g|f|v)?([xyz])(?: .*)?")


def has_gravity(values: Array) -> bool:
    """Check whether the numbers, in m/s^2, swing about plus or minus the acceleration of gravity."""
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
        found = _axes(table, by_gravity=True) or _axes(table, by_gravity=False)
        if found is None:
            break
        table = _with_one_axis(table, *found)
    return table


def _with_one_axis(table: Table, axes: Sequence[SourceColumn], unit: str) -> Table:
    first, second, _ = sorted(axes, key=lambda c: -amplitude(c.values))
    gravity, share = bool(unit), amplitude(second.values) / max(amplitude(first.values), 1e-300)
    quantity = "acceleration" if gravity else meaning(first.label, first.unit).quantity or "acceleration"
    doubts = table.doubts
    if share * STEEPER > 1.0:
        doubts += (
            f"{first.place} and {second.place} are axes of one sensor and move alike; "
            f"choose one, as in {ask(quantity, first.number)}",
        )
    why = "an accelerometer (their mean vector is gravity)" if gravity else "a sensor (by their names)"
    note = (
        f"{', '.join(c.place for c in axes)} are the axes of {why}; {first.place} moves most "
        f"and was taken as the {quantity} (the next axis moves {100.0 * share:.0f} % as much)"
    )
    said = first.unit or split_unit(first.label)[1] or unit
    taken = replace(first, quantity=quantity, unit=said, gravity=gravity, label=first.label or quantity)
    columns = tuple(taken if c is first else c for c in table.columns if c is first or c not in axes)
    return replace(table, columns=columns, notes=(*table.notes, note), doubts=doubts)


def _axes(table: Table, *, by_gravity: bool) -> tuple[Sequence[SourceColumn], str] | None:
    """Return three axes, and the unit in which the mean of their vector is gravity ("" by their names alone)."""
    columns = [c for c in table.columns if c.bad is None and is_measurable(c.values)]
    for three in (columns[i : i + 3] for i in range(len(columns) - 2)):
        names = [" ".join(words(split_unit(c.label)[0])) for c in three]
        axes = "".join(sorted(match[1] for name in names if (match := _AXIS.fullmatch(name))))
        said = [meaning(c.label, c.unit) for c in three]
        kinds = {s.quantity for s in said}
        if not by_gravity and axes == "xyz" and kinds in ({"acceleration"}, {"velocity"}):
            return three, ""
        units = {s.unit.quantity for s in said if s.unit is not None}
        if not by_gravity or (axes != "xyz" and any(c.label for c in three)) or units - {"acceleration"}:
            continue
        mean = float(np.linalg.norm([np.nanmedian(c.values) for c in three]))
        for scale, unit in ((1.0, "m/s^2"), (STANDARD_GRAVITY, "g")):
            meant = unit != "g" or "acceleration" in kinds or all(name.startswith("g") for name in names)
            if meant and abs(mean * scale / STANDARD_GRAVITY - 1.0) < WITHIN:
                return three, unit
    return None
