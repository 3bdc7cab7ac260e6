"""Which column is which quantity: what the options say, else what the headers say; where they do not, a doubt."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from daq.importing.column_numbers import amplitude, counts_rows, oscillation
from daq.importing.columns import INDEX, split_unit, words
from daq.importing.errors import problem
from daq.importing.options import NONE, QUANTITIES, ImportOptions, ask
from daq.importing.runs import rises_evenly
from daq.importing.table import SourceColumn, Table, listed, named
from daq.recording import MOTIONS

AXES = {axis: names for names in ("x y z", "roll pitch yaw", "phi theta psi") for axis in names.split()}
"""The names of one point's coordinates, and of one body's angles, by each of them."""

TOTALS = frozenset({"absolute", "abs", "total", "norm", "resultant", "modulus", "betrag", "absolut"})
"""Words of the size of a vector, beside its axes."""

AXIS_MOVES, SENSOR_MOVES, CHANNEL_MOVES = 5.0, 1.3, 20.0
"""So many times as much one axis moves as the others, one of a sensor, or one of several like channels as those that stand
still.
"""

_AXIS = re.compile(r"(?:.* )?(?:a|acc|accel|v)?([xyz])(?: .*)?")

REPEATS = 0.9999
"""Correlation from which on a column is another one in another unit."""


def choose_columns(
    table: Table, options: ImportOptions, notes: list[str], doubts: list[str]
) -> dict[str, SourceColumn]:
    """Return the column of each quantity that the table has; sentences about it go to `notes`, and where several columns
    could be meant, or none says that it is a motion, the likeliest is taken and a sentence goes to `doubts`.

    Raises ImportProblem when an option names no column, or nothing is left that could be a motion.
    """
    labels = {c.label.strip() for c in table.columns} - {""}
    likely = [c for c in table.columns if c.label[:1] != "d" or c.label.strip().lstrip("d") not in labels]
    chosen: dict[str, SourceColumn] = {}
    for quantity, wanted in options.named.items():
        column = named(table, wanted, quantity)
        if column.bad is None and not np.isfinite(column.values).any():
            raise problem(table.path, f"{column.place} holds no numbers", "name another one")
        other = next((q for q, c in chosen.items() if c is column), None)
        if other is not None:
            raise problem(
                table.path, f"{column.place} cannot be both {other} and {quantity}", "name another one for one of them"
            )  # fmt: skip
        chosen[quantity] = column
    beside = any(quantity in chosen for quantity in MOTIONS)
    for quantity in QUANTITIES:
        if quantity in options.columns or (quantity == "time" and options.rate is not None):
            continue
        free = _others(likely, chosen)
        found = _found(quantity, free, notes, doubts, beside=beside)
        if found is None and quantity == "time" and table.rate is None and len(table.columns) > 1:
            found = _rising(free, notes)
        if found is not None:
            chosen[quantity] = found
    if not any(quantity in chosen for quantity in MOTIONS):
        rest = [c for c in _others(likely, chosen) if c.said.quantity != "time"]
        among_all = not any(quantity in options.columns for quantity in MOTIONS)
        found = (_only_signal(rest, notes) if among_all else None) or _of_unknown_kind(table, rest, doubts)
        chosen["displacement"] = found
    return {quantity: replace(column, quantity=quantity) for quantity, column in chosen.items()}


def left_out(table: Table, chosen: Mapping[str, SourceColumn]) -> str:
    """Return a sentence that names the columns not used, or ""."""
    rest = _others(table.columns, chosen)
    return f"not used: {listed(rest)}" if rest else ""


def _others(columns: Sequence[SourceColumn], chosen: Mapping[str, SourceColumn]) -> list[SourceColumn]:
    taken = {column.number for column in chosen.values()}
    return [column for column in columns if column.number not in taken]


def _found(
    quantity: str, free: Sequence[SourceColumn], notes: list[str], doubts: list[str], *, beside: bool
) -> SourceColumn | None:
    """Return the one column whose header says this quantity best; `beside` a motion that was asked for, only one
    that says so clearly.
    """
    is_time = quantity == "time"
    likely = [c for c in free if c.said.quantity == quantity and np.isfinite(c.values).any()]
    if beside and not is_time:
        likely = [c for c in likely if c.said.strength > 1]
    likely = [c for c in likely if not c.said.derived] or likely
    best = max((c.said.strength for c in likely), default=0)
    likely = [c for c in likely if c.said.strength == best]
    likely = [c for c in likely if not set(words(c.label)) & (INDEX | TOTALS)] or likely
    if len(likely) > 1:
        likely = [c for c in likely if not c.clock] or likely if is_time else _moving(likely, notes)
    if len(likely) < 2 or all(np.array_equal(likely[0].values, c.values, equal_nan=True) for c in likely):
        return likely[0] if likely else None
    if beside and not is_time:
        return None
    first = likely[0] if is_time else _most(likely)
    leave = "" if is_time else f", or leave it out with {ask(quantity, NONE)}"
    stems = {split_unit(c.label)[0].rstrip("0123456789 _") for c in likely}
    runs = "; if they are releases of one rig, --run all" if len(stems) == 1 and "" not in stems else ""
    doubts.append(
        f"{len(likely)} {first.noun}s could be the {quantity}: {listed(likely)}; "
        f"choose one, as in {ask(quantity, _name(first))}{leave}{runs}"
    )
    return first


def _moving(columns: Sequence[SourceColumn], notes: list[str]) -> list[SourceColumn]:
    """Return those of several columns that could be meant: none that never moves, no axis or channel that stands still
    beside one of its kind, in one unit, and none that repeats another in another unit (of an angle and a length, the
    length is the one that repeats).
    """
    sensor = _axes_of_a_sensor(columns)
    kinds = {c.number: (("",) if sensor else _kind(c), c.said.unit_text) for c in columns}
    of_one_point = len(set(kinds.values())) == 1
    several = AXIS_MOVES if of_one_point else np.inf
    kept: list[SourceColumn] = []
    for column in sorted(columns, key=lambda c: (not c.said.angular, c.number)):
        own = amplitude(column.values)
        alike = [c for c in columns if own == 0.0 or kinds[c.number] == kinds[column.number]]
        first = max(alike, key=lambda c: amplitude(c.values))
        kind = kinds[column.number][0][0]
        factor = SENSOR_MOVES if sensor else several if kind in AXES.values() else CHANNEL_MOVES
        most = amplitude(first.values)
        if own == 0.0 < most or factor * own < most:
            notes.append(
                f"{column.place} moves {100.0 * own / most:.2g} % as much as {first.place}: left out"
            )
        elif any(kinds[c.number][1] != kinds[column.number][1] and _repeats(column, c) for c in kept):
            notes.append(f"{column.place} repeats another column in another unit: left out")
        else:
            kept.append(column)
    return [c for c in columns if c in kept]


def _axes_of_a_sensor(columns: Sequence[SourceColumn]) -> bool:
    """Check whether the columns are the three axes of one sensor of a velocity or an acceleration."""
    names = [" ".join(words(split_unit(c.label)[0])) for c in columns]
    axes = sorted(match[1] if (match := _AXIS.fullmatch(name)) else "" for name in names)
    return axes == ["x", "y", "z"] and columns[0].said.quantity in ("velocity", "acceleration")


def _kind(column: SourceColumn) -> tuple[str, ...]:
    """Strip a number, a letter or an axis from a name."""
    name = words(split_unit(column.label)[0])
    if len(name) == 1 and name[0] in AXES:
        return (AXES[name[0]],)
    bare = [word.rstrip("0123456789") for word in name]
    return tuple(w for w in bare if len(w) > 1) or tuple(w for w in bare if w) or ("",)


def _repeats(column: SourceColumn, other: SourceColumn) -> bool:
    there = np.isfinite(column.values) & np.isfinite(other.values)
    y, x = column.values[there], other.values[there]
    if len(y) < 8 or not amplitude(y) * amplitude(x) > 0.0:
        return False
    return abs(float(np.corrcoef(x, y)[0, 1])) > REPEATS


def _rising(free: Sequence[SourceColumn], notes: list[str]) -> SourceColumn | None:
    """Return the first column that could be anything by its name and rises evenly from end to end, as no motion does."""
    for column in free:
        said, name = column.said, set(words(column.label))
        if said.unit is not None or said.strength > 1 or said.other or name & INDEX:
            continue
        if rises_evenly(column) and not counts_rows(column.values):
            notes.append(
                f"{column.place} is not named as a time, but its numbers rise evenly: it was taken as time"
            )
            return column
    return None


def _most(columns: Sequence[SourceColumn]) -> SourceColumn:
    """Return the column that oscillates most."""
    return max(columns, key=lambda c: (oscillation(c.values), -c.number))


def _name(column: SourceColumn) -> str:
    label = " ".join(column.label.split())
    return label if 0 < len(label) <= 30 else str(column.number)


def _only_signal(rest: Sequence[SourceColumn], notes: list[str]) -> SourceColumn | None:
    """Return the only signal in counts, volts or pixels, which must be the displacement."""
    signals = [c for c in rest if c.said.unit and c.said.unit.si in ("count", "V", "px") and not c.said.other]
    if len(signals) != 1:
        return None
    notes.append(f"{signals[0].place} is the only signal beside the time: it was taken as the displacement")
    return signals[0]


def _of_unknown_kind(table: Table, rest: Sequence[SourceColumn], doubts: list[str]) -> SourceColumn:
    """Return the column that oscillates most, in counts where it names no unit, as a displacement of which nothing says so,
    with a doubt. Raises ImportProblem where there is none beside the time.
    """
    rest = [c for c in rest if oscillation(c.values) > 0.0 and not counts_rows(c.values)] or rest
    if not rest:
        raise problem(
            table.path, "holds no column beside the time",
            "name a file with a displacement, velocity or acceleration",
        )  # fmt: skip
    column = _most(rest)
    which = f"whether {rest[0].place} is" if len(rest) == 1 else f"which {rest[0].noun} is"
    which += " a displacement, velocity or acceleration" + (f": {listed(rest)}" if len(rest) > 1 else "")
    doubts.append(
        f"nothing says {which}; "
        f"say it and its unit (mm, deg, V ...), as in {ask('displacement', _name(column))} --unit displacement=mm"
    )
    return column if column.said.unit is not None else replace(column, unit="counts")
