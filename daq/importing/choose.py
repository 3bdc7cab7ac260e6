"""Which column is which quantity: what the options say, else what the headers say, never a silent guess."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from daq.importing.bob import on_an_arc
from daq.importing.columns import INDEX, Meaning, meaning, split_unit, words
from daq.importing.errors import ImportProblem, problem
from daq.importing.narrow import along_one_axis, narrowed, rising
from daq.importing.options import NONE, QUANTITIES, ImportOptions, ask
from daq.importing.still import oscillation
from daq.importing.table import SourceColumn, Table
from daq.importing.units import Unit
from daq.recording import Array

LARGEST = 1e150
SHORTEST = 20
EVENLY = 10.0
SWINGS = 0.3
MOTIONS = ("displacement", "velocity", "acceleration")


@dataclass(frozen=True, eq=False)
class Choice:
    """A column taken as a quantity; `unit` is what the file says about it, `asked` whether an option named it."""

    quantity: str
    column: SourceColumn
    unit: Unit | None
    unit_text: str
    angular: bool
    named_derived: bool
    asked: bool


def choose_columns(table: Table, options: ImportOptions, notes: list[str]) -> dict[str, Choice]:
    """Return the column of each quantity that the table has; sentences about it go to `notes`.

    Raises ImportProblem when several columns could be meant, or none is a motion.
    """
    meanings = {c.number: _meaning(c) for c in table.columns}
    choices = {
        quantity: _asked(table, quantity, wanted, meanings)
        for quantity, wanted in options.columns.items()
        if str(wanted).strip().lower() != NONE
    }
    _refuse_twice(table, choices)
    taken = {choice.column.number for choice in choices.values()}
    motion_asked = any(quantity in choices for quantity in MOTIONS)
    if _needs_clock(table, options, meanings):
        clock = _lettered_clock(table, taken, meanings)
        if clock is not None:
            choices["time"] = _clock_of(clock, meanings, notes)
            taken.add(clock.number)
    for quantity in QUANTITIES:
        if quantity in options.columns or quantity in choices:
            continue
        if quantity == "time" and options.rate is not None and _clocks(table, meanings) > 1:
            continue
        free = [c for c in table.columns if c.number not in taken]
        found = _found(table, quantity, free, meanings, notes, beside=motion_asked)
        if found is not None:
            choices[quantity] = found
            taken.add(found.column.number)
    if (
        "time" not in options.columns
        and "time" not in choices
        and options.rate is None
        and table.rate is None
    ):
        clock = _rising_first(table, taken) or _rising_alone(table, taken)
        if clock is not None:
            choices["time"] = _clock_of(clock, meanings, notes)
            taken.add(clock.number)
    if not any(quantity in (*choices, *options.columns) for quantity in MOTIONS):
        lone = [c for c in table.columns if c.number not in taken and _is_signal(meanings[c.number])]
        if len(lone) == 1:
            choices["displacement"] = _as_choice(
                "displacement", lone[0], meanings[lone[0].number], asked=False
            )
            taken.add(lone[0].number)
            notes.append(
                f"{lone[0].place} is the only signal beside the time: it was taken as the displacement"
            )
    if not any(quantity in choices for quantity in MOTIONS):
        known = "time" in choices or options.rate is not None or table.rate is not None
        raise _no_motion(table, taken, rate_known=known)
    return choices


def _clocks(table: Table, meanings: dict[int, Meaning]) -> int:
    return sum(meanings[c.number].quantity == "time" for c in table.columns)


def _needs_clock(table: Table, options: ImportOptions, meanings: dict[int, Meaning]) -> bool:
    """Return whether nothing says what the time is: no option, no rate and no column."""
    asked = "time" in options.columns or options.rate is not None
    return not asked and table.rate is None and not _clocks(table, meanings)


def _clock_of(column: SourceColumn, meanings: dict[int, Meaning], notes: list[str]) -> Choice:
    notes.append(
        f"{column.place} has no name that says so, but its numbers rise evenly: it was taken as time"
    )
    return _as_choice("time", column, meanings[column.number], asked=False)


def _lettered_clock(table: Table, taken: set[int], meanings: dict[int, Meaning]) -> SourceColumn | None:
    """Return the first column where it is named by a letter only, as the `x` of a plot, and rises from end to end.

    No motion does that in even steps; and another column must be left that could be one.
    """
    if len(table.columns) < 2 or table.columns[0].number in taken:
        return None
    first, said = table.columns[0], meanings[table.columns[0].number]
    if said.unit is not None or said.strength > 1 or words(first.label) not in (("x",), ("y",)):
        return None
    values = first.values
    if len(values) < SHORTEST or first.bad is not None or not np.isfinite(values).all():
        return None
    if not float(np.max(np.abs(values))) < LARGEST:
        return None
    steps = np.diff(values)
    return first if np.all(steps > 0.0) and float(np.max(steps)) < EVENLY * float(np.median(steps)) else None


def _is_signal(said: Meaning) -> bool:
    """Return whether a column has a unit that could be any sensor's: counts, volts, pixels."""
    return said.unit is not None and said.unit.si in ("count", "V", "px") and not said.other


def _refuse_twice(table: Table, choices: dict[str, Choice]) -> None:
    seen: dict[int, str] = {}
    for quantity, choice in choices.items():
        other = seen.setdefault(choice.column.number, quantity)
        if other != quantity:
            raise problem(
                table.path,
                f"{choice.column.place} cannot be both {other} and {quantity}",
                "name another one for one of them",
            )


def left_out(table: Table, choices: dict[str, Choice]) -> str:
    """Return a sentence that names the columns not used, or ""."""
    taken = {choice.column.number for choice in choices.values()}
    rest = [column.place for column in table.columns if column.number not in taken]
    if not rest:
        return ""
    shown = ", ".join(rest[:6]) + (f" and {len(rest) - 6} more" if len(rest) > 6 else "")
    return f"not used: {shown}"


def _meaning(column: SourceColumn) -> Meaning:
    if column.quantity is None:
        said = meaning(column.label, column.unit)
        return (
            Meaning("time", 2, None, "", False, False, False) if column.clock and not said.quantity else said
        )
    said = meaning("", column.unit)
    unit = said.unit if said.unit is not None and said.unit.quantity in (None, column.quantity) else None
    return Meaning(column.quantity, 3, unit, said.unit_text, said.angular, False, False)


def _as_choice(quantity: str, column: SourceColumn, said: Meaning, *, asked: bool) -> Choice:
    fits = said.unit is not None and said.unit.quantity in (None, quantity)
    return Choice(
        quantity,
        column,
        said.unit if fits else None,
        said.unit_text if fits else "",
        said.angular,
        said.derived,
        asked,
    )


def _asked(table: Table, quantity: str, wanted: str | int, meanings: dict[int, Meaning]) -> Choice:
    """Return the column that an option names, by number or by name."""
    text = " ".join(str(wanted).split())
    tests = (
        lambda c: c.label == str(wanted),
        lambda c: str(c.number) == text,
        lambda c: " ".join(c.label.split()).casefold() == text.casefold(),
        lambda c: " ".join(words(c.label)) == " ".join(words(text)) != "",
        lambda c: len(text) > 2 and text.casefold() in c.label.casefold(),
    )
    for test in tests:
        found = [c for c in table.columns if test(c)]
        if len(found) == 1:
            return _as_choice(quantity, found[0], meanings[found[0].number], asked=True)
        if found:
            raise problem(
                table.path,
                f"'{text}' could be {_listed(found)}",
                f"give its number, as in {ask(quantity, found[0].number)}",
            )
    raise problem(
        table.path, f"there is no {_noun(table)} '{text}' for the {quantity}; the file has {_listed(table.columns)}",
        "name one of these, or give its number",
    )  # fmt: skip


def _found(
    table: Table,
    quantity: str,
    free: Sequence[SourceColumn],
    meanings: dict[int, Meaning],
    notes: list[str],
    *,
    beside: bool,
) -> Choice | None:
    """Return the one column whose header says this quantity best; `beside` a motion that was asked for, only one
    that says so clearly.
    """
    candidates = [c for c in free if meanings[c.number].quantity == quantity and np.isfinite(c.values).any()]
    if quantity == "time" and not candidates:
        candidates = [c for c in free if words(c.label) == ("s",)][:1]
    elif quantity != "time" and beside:
        candidates = [c for c in candidates if meanings[c.number].strength > 1]
    candidates = [c for c in candidates if not meanings[c.number].derived] or candidates
    best = max((meanings[c.number].strength for c in candidates), default=0)
    top = [c for c in candidates if meanings[c.number].strength == best]
    if len(top) > 1:
        top = [c for c in top if not set(words(c.label)) & INDEX] or top
    if not top:
        return None
    if len(top) > 1:
        top, why = rising(top) if quantity == "time" else narrowed(top, meanings, quantity)
        notes.extend(why)
    if len(top) > 1 and quantity != "time" and not _angle_of(top):
        top, why = along_one_axis(top, meanings)
        notes.extend(why)
    if len(top) > 1 and not _same_numbers(top):
        if beside and quantity != "time":
            return None
        leave = f", or leave it out with {ask(quantity, NONE)}" if quantity != "time" else ""
        raise problem(
            table.path, f"{len(top)} {top[0].noun}s could be the {quantity}: {_listed(top)}",
            f"choose one, as in {ask(quantity, _name(_likely(top)))}{leave}{_or_runs(top)}{_or_angle(top)}",
            options=(_angle_of(top) or ask(quantity, _name(_likely(top))),),
        )  # fmt: skip
    return _as_choice(quantity, top[0], meanings[top[0].number], asked=False)


def _or_runs(columns: Sequence[SourceColumn]) -> str:
    names = {split_unit(c.label)[0].rstrip("0123456789 _") for c in columns}
    return "; if they are releases of one rig, --run all" if len(names) == 1 and "" not in names else ""


def _or_angle(columns: Sequence[SourceColumn]) -> str:
    pair = _pair(columns)
    if pair is None:
        return ""
    if any(oscillation(c.values) < SWINGS for c in pair) and not _angle_of(columns):
        return ""
    return f"; if they are a pendulum's bob, its angle is {_angle_from(pair)}"


def _angle_of(columns: Sequence[SourceColumn]) -> str:
    """Return the option that makes an angle of columns called x and y that lie on an arc, or ""."""
    pair = _pair(columns)
    if pair is None or len(columns) > 3 or not on_an_arc(*pair):
        return ""
    return _angle_from(pair)


def _angle_from(pair: tuple[SourceColumn, SourceColumn]) -> str:
    return f"--angle-from {','.join(split_unit(c.label)[0].strip() for c in pair)}"


def _pair(columns: Sequence[SourceColumn]) -> tuple[SourceColumn, SourceColumn] | None:
    """Return the columns called x and y."""
    found = {split_unit(c.label)[0].strip().lower(): c for c in columns}
    return (found["x"], found["y"]) if {"x", "y"} <= set(found) else None


def _likely(columns: Sequence[SourceColumn]) -> SourceColumn:
    """Return the column that oscillates most."""
    return max(columns, key=lambda c: (oscillation(c.values), -c.number))


def _same_numbers(columns: Sequence[SourceColumn]) -> bool:
    return all(np.array_equal(columns[0].values, c.values, equal_nan=True) for c in columns[1:])


def _rising_alone(table: Table, taken: set[int]) -> SourceColumn | None:
    """Return the only column that rises all the way in even steps, of columns without names; None where none does alone."""
    if any(words(column.label) for column in table.columns):
        return None
    found = [c for c in table.columns if c.number not in taken and c.bad is None and _is_a_clock(c.values)]
    return found[0] if len(found) == 1 else None


def _is_a_clock(values: Array) -> bool:
    """Whether numbers rise from each row to the next in steps that are nearly alike, and do not count the rows."""
    if len(values) < SHORTEST or not np.isfinite(values).all() or not float(np.max(np.abs(values))) < LARGEST:
        return False
    steps = np.diff(values)
    if np.all(steps == 1.0) and values[0] == np.rint(values[0]):
        return False
    return bool(np.all(steps > 0.0)) and float(np.max(steps)) < EVENLY * float(np.median(steps))


def _rising_first(table: Table, taken: set[int]) -> SourceColumn | None:
    """Return the first free column if its numbers rise all the way and nearly evenly."""
    if not table.columns or table.columns[0].number in taken or table.columns[0].bad is not None:
        return None
    column = table.columns[0]
    if (
        words(column.label)
        and not set(words(column.label)) <= INDEX
        and words(column.label) != ("x", "value")
    ):
        return None
    values = column.values
    if set(words(column.label)) & INDEX or len(table.columns) < 2 or len(values) < 3:
        return None
    if not float(np.max(np.abs(values))) < LARGEST:
        return None
    steps = np.diff(values)
    even = np.all(steps > 0.0) and float(np.max(steps)) < 1e3 * float(np.median(steps))
    if np.all(steps == 1.0) and values[0] == np.rint(values[0]):
        return None  # rows that were counted, from whatever number
    return column if even and np.isfinite(values).all() else None


def _name(column: SourceColumn) -> str:
    label = " ".join(column.label.split())
    return label if 0 < len(label) <= 30 else str(column.number)


def _noun(table: Table) -> str:
    return table.columns[0].noun if table.columns else "column"


def _listed(columns: Sequence[SourceColumn]) -> str:
    shown = ", ".join(c.place for c in columns[:8])
    return shown + (f" and {len(columns) - 8} more" if len(columns) > 8 else "")


def _what_is_not_said(table: Table, rest: Sequence[SourceColumn]) -> str:
    if len(rest) == 1:
        return f"nothing says whether {rest[0].place} is a displacement, velocity or acceleration"
    return f"nothing says which {_noun(table)} is a displacement, velocity or acceleration: {_listed(rest)}"


def _no_motion(table: Table, taken: set[int], *, rate_known: bool) -> ImportProblem:
    rest = [c for c in table.columns if c.number not in taken]
    rest = [c for c in rest if oscillation(c.values) > 0.0] or rest
    if not rest:
        return problem(
            table.path,
            "holds no column beside the time",
            "name a file with a displacement, velocity or acceleration",
        )
    asked = (ask("displacement", _name(_likely(rest))), "--unit displacement=UNIT")
    return problem(
        table.path, _what_is_not_said(table, rest),
        f"say it and its unit (mm, deg, V ...), as in {' '.join(asked)}",
        options=asked if rate_known else (*asked, "--rate HZ"),
    )  # fmt: skip
