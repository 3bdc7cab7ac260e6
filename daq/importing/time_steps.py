"""A column that holds the time since the last line, instead of the time."""

import re
from dataclasses import replace

import numpy as np

from daq.importing.columns import meaning, split_unit, words
from daq.importing.options import ImportOptions
from daq.importing.still import is_measurable
from daq.importing.table import SourceColumn, Table

_NAMES = re.compile(
    r"(?:time|zeit|ms|millis)?[\s_-]*(?:from|since|seit)[\s_-]*(?:the[\s_-]*)?(?:previous|last|letzte\w*|vorig\w*).*"
    r"|.*(?:time|zeit)[\s_-]*(?:diff\w*|delta|step|increment|differenz|schritt)|delta[\s_-]*(?:t|time|zeit)|dt|diff|Δ\s*t",
    re.I,
)
FEWEST = 8
MOST_VALUES = 30


def with_stamps(table: Table, options: ImportOptions) -> Table:
    """Return the table with its column of time steps, if that is its clock, summed up to time stamps.

    Such a column is known by its name, or, without any, by whole numbers that are nearly alike, where no other
    column is the time.
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
        if _NAMES.fullmatch(name) and _are_steps(column, named=True):
            return i
    if any(
        meaning(c.label, c.unit).quantity == "time" or c.clock or c.quantity == "time" for c in table.columns
    ):
        return None
    nameless = [i for i in (len(table.columns) - 1, 0) if not words(table.columns[i].label)]
    return next(
        (i for i in nameless if len(table.columns) > 1 and _are_steps(table.columns[i], named=False)), None
    )


def _are_steps(column: SourceColumn, *, named: bool) -> bool:
    """Return whether a column's numbers, after the first, are positive and nearly alike."""
    values = column.values
    if (
        column.bad is not None
        or len(values) < FEWEST
        or not np.isfinite(values).all()
        or not is_measurable(values)
    ):
        return False
    steps = values[1:]
    middle = float(np.median(steps))
    if not middle > 0.0 or float(np.min(steps)) < 0.0 or values[0] < 0.0:
        return False
    alike = float(np.mean(np.abs(steps - middle) <= 0.5 * middle))
    if named:
        return alike > 0.9 and not (np.all(steps > values[:-1]))
    whole = bool(np.all(values == np.rint(values)))
    different = len(np.unique(steps))
    begins = values[0] == 0.0 or different > 1
    return (
        alike > 0.95
        and whole
        and begins
        and different <= MOST_VALUES
        and float(np.max(values)) < 10.0 * middle
    )
