"""Three axes of an accelerometer: known by the gravity in them; the one that moves is taken."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from daq.importing.columns import meaning, split_unit, words
from daq.importing.errors import problem
from daq.importing.options import ImportOptions, ask
from daq.importing.still import amplitude
from daq.importing.table import SourceColumn, Table
from daq.importing.units import STANDARD_GRAVITY
from daq.recording import Array

AXES = ("x", "y", "z")
WITHIN = 0.03
"""Gravity is found again to 3 %: the calibration of a phone's accelerometer."""

STEEPER = 1.3
"""The moving axis moves this much more than the next one."""


def has_gravity(values: Array) -> bool:
    """Return whether the numbers, in m/s^2, swing about plus or minus the acceleration of gravity."""
    finite = values[np.isfinite(values)]
    return bool(len(finite)) and abs(abs(float(np.median(finite))) / STANDARD_GRAVITY - 1.0) < WITHIN


def with_moving_axis(table: Table, options: ImportOptions) -> Table:
    """Return the table with one axis of a three-axis sensor as its acceleration, the other two left out.

    Three columns are such a sensor if the mean of their vector is gravity, or if they are named as the x, y and z of
    an acceleration. Raises ImportProblem when no axis moves more than the others.
    """
    if any(q in options.columns for q in ("displacement", "velocity", "acceleration")) or options.angle_from:
        return table
    found = _by_gravity(table) or _by_name(table)
    if found is None:
        return table
    axes, scale, gravity = found
    amplitudes = [amplitude(c.values) for c in axes]
    order = np.argsort(amplitudes)[::-1]
    first, second = axes[int(order[0])], axes[int(order[1])]
    if amplitudes[order[0]] < STEEPER * amplitudes[order[1]]:
        raise problem(
            table.path,
            f"{first.place} and {second.place} are axes of one accelerometer and move alike",
            f"choose one, as in {ask('acceleration', first.number)}",
            options=(ask("acceleration", first.number),),
        )
    share = 100.0 * amplitudes[order[1]] / amplitudes[order[0]]
    why = "their mean vector is gravity" if gravity else "by their names"
    note = (
        f"{', '.join(c.place for c in axes)} are the axes of an accelerometer ({why}); {first.place} moves most "
        f"and was taken as the acceleration (the next axis moves {share:.0f} % as much)"
    )
    unit = first.unit or split_unit(first.label)[1] or ("m/s^2" if scale == 1.0 else "g")
    taken = replace(
        first, quantity="acceleration", unit=unit, gravity=gravity, label=first.label or "acceleration"
    )
    rest = {c.number for c in axes} - {first.number}
    columns = tuple(taken if c is first else c for c in table.columns if c.number not in rest)
    return replace(table, columns=columns, notes=(*table.notes, note))


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


def _triples(table: Table) -> list[Sequence[SourceColumn]]:
    columns = [c for c in table.columns if c.bad is None and np.isfinite(c.values).any()]
    return [columns[i : i + 3] for i in range(len(columns) - 2)]


def _by_gravity(table: Table) -> tuple[Sequence[SourceColumn], float, bool] | None:
    for three in _triples(table):
        named = [_axis(c) for c in three]
        if not (named == ["?"] * 3 or sorted(named) == list(AXES)):
            continue
        said = [meaning(c.label, c.unit) for c in three]
        if any(s.unit is not None and s.unit.quantity != "acceleration" for s in said):
            continue
        mean = float(np.linalg.norm([np.nanmedian(c.values) for c in three]))
        for scale in (1.0, STANDARD_GRAVITY):
            accelerations = scale == 1.0 or any(s.quantity == "acceleration" for s in said)
            if accelerations and abs(mean * scale / STANDARD_GRAVITY - 1.0) < WITHIN:
                units = [s.unit.scale for s in said if s.unit is not None]
                return three, units[0] if units else scale, True
    return None


def _by_name(table: Table) -> tuple[Sequence[SourceColumn], float, bool] | None:
    for three in _triples(table):
        said = [meaning(c.label, c.unit) for c in three]
        if sorted(_axis(c) for c in three) == list(AXES) and all(s.quantity == "acceleration" for s in said):
            return three, said[0].unit.scale if said[0].unit is not None else 1.0, False
    return None
