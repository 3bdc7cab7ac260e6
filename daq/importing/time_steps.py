"""A column that holds the time since the last line, instead of the time."""

import re
from dataclasses import replace

import numpy as np

from daq.importing.columns import split_unit
from daq.importing.options import ImportOptions
from daq.importing.still import is_measurable
from daq.importing.table import SourceColumn, Table

_NAMES = re.compile(
    r"(?:time|zeit|ms|millis)?[\s_-]*(?:from|since|seit)[\s_-]*(?:the[\s_-]*)?(?:previous|last|letzte\w*|vorig\w*).*"
    r"|.*(?:time|zeit)[\s_-]*(?:diff\w*|delta|step|increment|differenz|schritt)|delta[\s_-]*(?:t|time|zeit)|dt|diff|Δ\s*t",
    re.I,
)
FEWEST = 8


def with_stamps(table: Table, options: ImportOptions) -> Table:
    """Return the table with its column of time steps, if that is its clock, summed up to time stamps.

    Such a column is known by its name.
    """
    if options.rate is not None or "time" in options.columns or table.rate is not None:
        return table
    index = _find(table)
    if index is None:
        return table
    column = table.columns[index]
    _, text, unit = split_unit(column.label)
    if unit is None or unit.quantity != "time":
        whole = bool(np.all(column.values == np.rint(column.values)))
        text = column.unit or ("ms" if whole and np.median(column.values) >= 1.0 else "s")
    stamps = np.cumsum(column.values) - column.values[0]
    step = float(np.median(column.values[1:]))
    note = (
        f"{column.place} holds steps of about {step:.4g} {text}, not times: "
        "it was taken as the time since the line before, and summed up"
    )
    made = replace(column, label="time", values=stamps, unit=text, quantity="time", steps=True)
    columns = (*table.columns[:index], made, *table.columns[index + 1 :])
    return replace(table, columns=columns, notes=(*table.notes, note))


def _find(table: Table) -> int | None:
    for i, column in enumerate(table.columns):
        name = split_unit(column.label)[0].strip()
        if _NAMES.fullmatch(name) and _are_steps(column):
            return i
    return None


def _are_steps(column: SourceColumn) -> bool:
    """Return whether a column's numbers, after the first, are positive and nearly alike, and no times."""
    values, steps = column.values, column.values[1:]
    if column.bad is not None or len(values) < FEWEST or not np.isfinite(values).all():
        return False
    middle = float(np.median(steps))
    if not is_measurable(values) or not middle > 0.0 or float(np.min(values)) < 0.0:
        return False
    alike = float(np.mean(np.abs(steps - middle) <= 0.5 * middle))
    return alike > 0.9 and not np.all(steps > values[:-1])
