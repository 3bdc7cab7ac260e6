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
    """Return the table with its column of time steps, known by its name, summed up to time stamps, if that is its clock."""
    if options.rate is not None or "time" in options.columns or table.rate is not None:
        return table
    column = next((c for c in table.columns if _is_called_so(c) and _are_steps(c)), None)
    if column is None:
        return table
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
    columns = tuple(made if c is column else c for c in table.columns)
    return replace(table, columns=columns, notes=(*table.notes, note))


def _is_called_so(column: SourceColumn) -> bool:
    return _NAMES.fullmatch(split_unit(column.label)[0].strip()) is not None


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
