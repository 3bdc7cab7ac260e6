"""From a table to its recordings, by a recipe alone: nothing is guessed here."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from daq.importing.bob import angle_of
from daq.importing.errors import ImportProblem, problem, require_few
from daq.importing.recipe import Column, Part, Recipe
from daq.importing.runs import MOST_RUNS, of_each, part_of, pieces, rows_of
from daq.importing.stamps import NoClock
from daq.importing.table import SourceColumn, Table, listed
from daq.importing.timebase import Timebase, find_gaps, from_stamps, on_clock
from daq.importing.units import SI_LINEAR, Unit, parse_scaled_unit
from daq.plain_text import counted, one_line
from daq.recording import MOTIONS, Array, Channel, Recording

ORDER: Final = (*MOTIONS, "force")
NO_MOTION = "the recipe names no displacement, velocity or acceleration", "give one column this role"
NO_RATE = (
    "no column is named as the time, none rises throughout, and the file names no rate; name the time with "
    "--column time=..., or give the rate in Hz with --rate (in a recipe: rate)"
)
FEWEST_ROWS = 8
FEWEST = 50
"""Samples of five cycles with ten readings each: of fewer nothing can be told, and tables of results are as short."""
LARGEST = 1e150
MIN_RATE, MAX_RATE = 1e-3, 1e7
WIDE = 40
"""Columns from which on a recipe lists only those that have a role."""


@dataclass(frozen=True, eq=False)
class Reading:
    """A column of one run as a quantity; its numbers times `scale` are in the unit's SI."""

    column: SourceColumn
    unit: Unit
    field: Column

    def in_si(self, table: Table, quantity: str) -> Array:
        """Return the column in SI, shape (rows,), NaN where it is empty; ImportProblem for text or an impossible size."""
        column = self.column
        if column.bad is not None:
            line, text = column.bad
            raise problem(
                table.path, f"'{text}' in {column.place} is not a number",
                "repair or remove the line, or choose another column", line=line, column=column.number,
            )  # fmt: skip
        zero = self.field.zero if isinstance(self.field.zero, float) and not column.arc else 0.0
        values = (column.values - zero) * (self.unit.scale * self.field.sign)
        too_large = np.abs(values) > LARGEST
        if too_large.any():
            row = int(np.argmax(too_large))
            raise problem(
                table.path, f"{column.values[row]:.3g} is too large to be a measured {quantity}",
                "repair or remove the line", line=table.line(row), column=column.number,
            )  # fmt: skip
        return values


@np.errstate(over="ignore", invalid="ignore")  # numbers too large to be measured are refused
def apply(table: Table, recipe: Recipe) -> tuple[Recording, ...]:
    """Return the recordings that a recipe makes of a table: one for each run and part.

    A run that cannot be read is left out, and the notes of the others say why. Raises ImportProblem when none can.
    """
    made, left_out = of_each(_runs(table, recipe), lambda run: _recordings(*run, recipe))
    return tuple(replace(one, notes=(*one.notes, *left_out)) for parts in made for one in parts)


def matched(table: Table, recipe: Recipe) -> dict[int, Column]:
    """Return the recipe's field of each column that has one, by the column's number.

    Raises ImportProblem when a field with a role is in no column, or in several.
    """
    found: dict[int, Column] = {}
    names = [(one_line(c.label).strip(), c) for c in table.columns]
    for field in recipe.fields:
        wanted = field.name.strip()
        same = [c for name, c in names if wanted in ("", name) and field.column in (None, c.number)]
        if len(same) == 1:
            found[same[0].number] = field
        elif field.role != "ignored":
            wanted = f"'{wanted}'" if wanted else f"{field.column}"
            raise problem(
                table.path, f"the recipe's {field.role} is in column {wanted}, and the file has {listed(table.columns)}",
                "correct the recipe, or import without it",
            )  # fmt: skip
    return found


def fits(table: Table, recipe: Recipe) -> bool:
    """Check whether a recipe lists the columns of a table, neither more nor fewer (all, or those with a role of many), and
    the file states the same units. A recipe without names is of files without names.
    """
    try:
        found = matched(table, recipe)
    except ImportProblem:
        return False
    if recipe.stated not in (None, stated(table)):
        return False
    if any(c.label.strip() for c in table.columns) != any(field.name.strip() for field in recipe.fields):
        return False
    all_of_it = len(recipe.fields) == len(table.columns) or len(table.columns) > WIDE
    return table.format == recipe.format and all_of_it and len(found) == len(recipe.fields)


def stated(table: Table) -> tuple[str, ...]:
    """Return the units that a file states: in the lines above its numbers, or of each column."""
    return table.stated or tuple(sorted({one_line(c.unit) for c in table.columns if c.unit}))


def _runs(table: Table, recipe: Recipe) -> list[tuple[Table, Mapping[int, Column]]]:
    """Return the table and the fields of each run that the recipe reads."""
    fields = {n: f for n, f in matched(table, recipe).items() if f.role != "ignored"}
    columns = [c for c in table.columns if c.number in fields]
    if all(f.role in ("run", "time", "time_step") for f in fields.values()):
        raise problem(table.path, *NO_MOTION)
    names = list(dict.fromkeys(f.run for f in fields.values() if f.run))
    counter = next((c for c in columns if fields[c.number].role == "run"), None)
    if counter is not None or recipe.restarts:
        by = counter or next((c for c in columns if fields[c.number].role == "time"), None)
        if by is None:
            raise problem(
                table.path,
                "the recipe cuts where the time restarts, and names no time",
                "give one column this role",
            )
        tables = pieces(table, [c for c in columns if c is not counter], by, counted=counter is not None)
        require_few(table.path, len(tables), MOST_RUNS, f"runs in {by.place}", "give another role")
    else:
        tables = (
            [_side_by_side(table, columns, fields, name) for name in names]
            if names
            else [replace(table, columns=tuple(columns))]
        )
    if recipe.runs:
        kept = [run for run in tables if run.run in recipe.runs]
        if not kept:
            raise problem(
                table.path, f"has no run '{recipe.runs[0]}'",
                f"it holds runs {', '.join(run.run for run in tables)}" if len(tables) > 1 else
                "it holds one recording: leave --run out",
            )  # fmt: skip
        tables = kept
    return [(_noted(run), {c.number: fields[c.number] for c in run.columns}) for run in tables]


def _noted(run: Table) -> Table:
    numbers = ", ".join(str(column.number) for column in run.columns)
    note = f"run {run.run} of the file: columns {numbers}, {len(run.columns[0].values)} rows"
    return replace(run, notes=(*run.notes, note)) if run.run else run


def _side_by_side(
    table: Table, columns: Sequence[SourceColumn], fields: dict[int, Column], name: str
) -> Table:
    """Return the columns of a run and those of all runs, in the rows that it has."""
    own = [c for c in columns if fields[c.number].run in ("", name)]
    return part_of(table, name, own, rows_of(own, [c for c in own if fields[c.number].role == "time"]))


def readings_of(table: Table, fields: Mapping[int, Column]) -> dict[str, Reading]:
    """Return the readings of one run by their quantity. Raises ImportProblem when two columns are one quantity."""
    found: dict[str, Reading] = {}
    for column in table.columns:
        field = fields[column.number]
        column = replace(column, values=_counted_on(column.values, field.wraps)) if field.wraps else column
        role = "time" if field.role == "time_step" else field.role
        if field.role == "time_step":
            column = replace(column, values=np.cumsum(column.values) - column.values[0])
        if role in found:
            raise problem(
                table.path, f"{found[role].column.place} and {column.place} cannot both be the {role}",
                "ignore one in the recipe, or give each a run",
            )  # fmt: skip
        unit = parse_scaled_unit(field.unit) or SI_LINEAR.get(role, SI_LINEAR["displacement"])
        found[role] = Reading(column, unit, field)
    x, y = found.pop("x", None), found.pop("y", None)
    if x is not None and y is not None:
        found.setdefault("displacement", _angle(table, x, y))
    if not any(quantity in found for quantity in MOTIONS):
        raise problem(table.path, *NO_MOTION)
    return found


def _counted_on(values: Array, step: float) -> Array:
    """Return numbers that begin again after `step`, counted on, their median within half a `step` of 0; NaN stay."""
    there = np.isfinite(values)
    on = np.unwrap(values[there], period=step)
    made = values.copy()
    made[there] = on - step * np.rint(np.median(on) / step)
    return made


def _angle(table: Table, x: Reading, y: Reading) -> Reading:
    across, up = x.field.zero, y.field.zero
    pivot = (across, up) if isinstance(across, float) and isinstance(up, float) else None
    y.in_si(table, "displacement")  # refuses text; that in x is refused with the angle
    angle, _ = angle_of(table, x.column, y.column, pivot)
    return Reading(angle, Unit(1.0, "rad", "displacement"), x.field)


def _recordings(table: Table, fields: Mapping[int, Column], recipe: Recipe) -> list[Recording]:
    """Return the recordings of one run: one, or one for each part that the recipe cuts."""
    readings = readings_of(table, fields)
    values = np.array([readings[q].in_si(table, q) for q in ORDER if q in readings])
    parts = recipe.parts or (Part(),)
    made = [_recording(*_within(table, readings, values, recipe, part), recipe) for part in parts]
    if len(parts) == 1:
        return made
    return [replace(one, run=f"{one.run}{'.' if one.run else ''}{k}") for k, one in enumerate(made, start=1)]


def _within(
    table: Table, readings: dict[str, Reading], values: Array, recipe: Recipe, part: Part
) -> tuple[Table, dict[str, Reading], Array]:
    """Return the rows that lie between two times of the file, with half a sampling interval to either side."""
    if part == Part():
        return table, readings, values
    time = readings.get("time")
    if recipe.rate is None and time is not None:
        at = time.in_si(table, "time")
    else:
        at = np.arange(values.shape[1]) / (recipe.rate or table.rate or 1.0)
    first, last = (np.nan if side is None else side for side in (part.start, part.stop))
    margin = 0.5 * float(np.abs(np.nanmedian(np.diff(at))))
    rows = np.flatnonzero(np.isfinite(at) & ~(at < first - margin) & ~(at > last + margin))
    if len(rows) < FEWEST_ROWS:
        raise problem(
            table.path, "holds nothing between these times",
            f"its times go from {np.nanmin(at):.6g} s to {np.nanmax(at):.6g} s",
        )  # fmt: skip
    notes = (*table.notes, f"rows {rows[0] + 1} to {rows[-1] + 1} of the table")
    own = replace(part_of(table, table.run, table.columns, rows), notes=notes)
    kept = {
        quantity: replace(reading, column=replace(reading.column, values=reading.column.values[rows]))
        for quantity, reading in readings.items()
    }
    return own, kept, values[:, rows]


def _recording(table: Table, readings: dict[str, Reading], values: Array, recipe: Recipe) -> Recording:
    quantities = [q for q in ORDER if q in readings]
    _require_enough(table, values.shape[1])
    clock = _clock(table, readings, values, recipe)
    values = values[:, clock.rows]
    _require_enough(table, len(clock.rows))
    if not MIN_RATE <= clock.rate <= MAX_RATE:
        raise problem(
            table.path, f"its rate would be {clock.rate:.4g} Hz",
            "give the unit of the time with --unit time=..., or --rate in Hz",
        )  # fmt: skip
    samples, valid = on_clock(values, clock)
    if not valid.any():
        raise problem(
            table.path, "has no sample in which all channels hold a number",
            "leave a channel out, as in --column acceleration=none",
        )  # fmt: skip
    for row, quantity in enumerate(quantities):
        if readings[quantity].field.zero == "median":
            samples[row] -= np.nanmedian(samples[row])
    notes = (*table.notes, *_invalid(table, quantities, values, clock), *clock.notes)
    if samples.shape[1] < FEWEST:
        notes += (
            f"{samples.shape[1]} samples only: the amplitudes or periods of swings are no recording; what is needed is the "
            "motion itself, five cycles or more with at least ten readings each",
        )
    channels = tuple(Channel(readings[q].column.label or q, q, readings[q].unit.si) for q in quantities)
    recording = Recording(
        clock.rate, channels, samples, valid, find_gaps(valid, clock), clock.rate_std, None, notes, table.run
    )
    if clock.stamps is None:
        return recording
    rows, there = on_clock(values, replace(clock, stamps=None))
    return replace(recording, as_read=Recording(clock.rate, channels, rows, there))


def _require_enough(table: Table, count: int) -> None:
    if count < FEWEST_ROWS:
        has = f"has {counted(count, 'sample', 'samples')}"
        raise problem(table.path, has, f"a recording needs at least {FEWEST_ROWS}")


def _clock(table: Table, readings: dict[str, Reading], values: Array, recipe: Recipe) -> Timebase:
    """Return the clock: the recipe's rate, else the stamps, else the rate that the file names."""
    time = readings.get("time")
    if recipe.rate is None and time is not None:
        time.in_si(table, "time")  # refuses what is no time at all
        unit = replace(time.unit, scale=time.unit.scale * time.field.sign)
        return from_stamps(table, time.column, unit, values, resample=recipe.resample, even=recipe.even)
    if recipe.rate is not None:
        rate, said = recipe.rate, "as given" if time is None else "in place of the time stamps"
    elif table.rate is not None:
        rate, said = table.rate, f"from {table.rate_source}"
    else:
        raise NoClock(table.path.name, NO_RATE, {})
    every = np.arange(values.shape[1])
    return Timebase(rate, None, every, every, len(every), notes=(f"rate {rate:.6g} Hz, {said}",))


def _invalid(table: Table, quantities: Sequence[str], values: Array, clock: Timebase) -> list[str]:
    """Return sentences on samples that hold no number."""
    notes = []
    for quantity, channel in zip(quantities, values, strict=True):
        holes = np.flatnonzero(~np.isfinite(channel))
        if len(holes):
            line = table.line(int(clock.rows[holes[0]]))
            where = f", the first in line {line}" if line else ""
            notes.append(
                f"{len(holes)} of {len(channel)} samples of the {quantity} are empty or not finite{where}; "
                "they count as invalid"
            )
    return notes
