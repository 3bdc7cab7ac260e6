"""Which column is which quantity: what the options say, else what the headers say, never a silent guess."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from daq.importing.columns import INDEX, Meaning, meaning, split_unit, words
from daq.importing.errors import problem
from daq.importing.named import listed, named
from daq.importing.narrow import along_one_axis, clocks, narrowed
from daq.importing.options import NONE, QUANTITIES, ImportOptions, ask
from daq.importing.runs import rises_evenly
from daq.importing.still import oscillation
from daq.importing.table import SourceColumn, Table
from daq.importing.units import COUNT, Unit
from daq.recording import Array

MOTIONS = ("displacement", "velocity", "acceleration")
_SOMETHING_ELSE = Meaning(None, 0, None, "", False, False, True)


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


def choose_columns(
    table: Table, options: ImportOptions, notes: list[str], doubts: list[str]
) -> dict[str, Choice]:
    """Return the column of each quantity that the table has; sentences about it go to `notes`, and where several columns
    could be meant, or none says that it is a motion, the likeliest is taken and a sentence goes to `doubts`.

    Raises ImportProblem when an option names no column, or nothing is left that could be a motion.
    """
    meanings = {c.number: _meaning(c) for c in table.columns}
    meanings |= {c.number: _SOMETHING_ELSE for c in _derivatives_by_name(table)}
    choices = {
        quantity: _asked(table, quantity, wanted, meanings)
        for quantity, wanted in options.columns.items()
        if str(wanted).strip().lower() != NONE
    }
    _refuse_twice(table, choices)
    asked = any(quantity in choices for quantity in MOTIONS)
    for quantity in QUANTITIES:
        if quantity in options.columns:
            continue
        if quantity == "time" and options.rate is not None and _clocks(table, meanings) > 1:
            continue
        taken = {choice.column.number for choice in choices.values()}
        free = [c for c in table.columns if c.number not in taken]
        column = _found(table, quantity, free, meanings, (notes, doubts), beside=asked)
        if column is None and quantity == "time" and options.rate is None and table.rate is None:
            column = _rising(free, meanings, notes) if len(table.columns) > 1 else None
        if column is not None:
            choices[quantity] = _as_choice(quantity, column, meanings[column.number], asked=False)
    if any(quantity in choices for quantity in MOTIONS):
        return choices
    taken = {choice.column.number for choice in choices.values()}
    rest = [c for c in table.columns if c.number not in taken]
    lone = [c for c in rest if _is_signal(meanings[c.number])]
    if len(lone) == 1 and not any(quantity in options.columns for quantity in MOTIONS):
        notes.append(f"{lone[0].place} is the only signal beside the time: it was taken as the displacement")
    else:
        lone = [_of_unknown_kind(table, rest, doubts)]
    said = meanings[lone[0].number]
    said = said if said.unit is not None else replace(said, unit=COUNT, unit_text="counts")
    choices["displacement"] = _as_choice("displacement", lone[0], said, asked=False)
    return choices


def _derivatives_by_name(table: Table) -> list[SourceColumn]:
    """Return the columns called dX or ddX beside one called X."""
    names = {c.label.strip() for c in table.columns if c.label.strip()}
    return [c for c in table.columns if (name := c.label.strip())[:1] == "d" and name.lstrip("d") in names]


def _clocks(table: Table, meanings: dict[int, Meaning]) -> int:
    return sum(meanings[c.number].quantity == "time" for c in table.columns)


def _rising(
    free: Sequence[SourceColumn], meanings: dict[int, Meaning], notes: list[str]
) -> SourceColumn | None:
    """Return the first column that could be anything by its name and rises evenly from end to end, as no motion does."""
    for column in free:
        said, name = meanings[column.number], set(words(column.label))
        if said.unit is not None or said.strength > 1 or said.other or name & INDEX:
            continue
        if rises_evenly(column) and not _counts_rows(column.values):
            notes.append(
                f"{column.place} has no name that says so, but its numbers rise evenly: it was taken as time"
            )
            return column
    return None


def _counts_rows(values: Array) -> bool:
    return bool(np.all(np.diff(values) == 1.0)) and bool(values[0] == np.rint(values[0]))


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
    column = named(table, wanted, quantity)
    if column.bad is None and not np.isfinite(column.values).any():
        raise problem(table.path, f"{column.place} holds no numbers", "name another one")
    return _as_choice(quantity, column, meanings[column.number], asked=True)


def _found(
    table: Table,
    quantity: str,
    free: Sequence[SourceColumn],
    meanings: dict[int, Meaning],
    said: tuple[list[str], list[str]],
    *,
    beside: bool,
) -> SourceColumn | None:
    """Return the one column whose header says this quantity best; `beside` a motion that was asked for, only one
    that says so clearly.
    """
    notes, doubts = said
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
    if len(top) > 1:
        top, why = clocks(table, top) if quantity == "time" else narrowed(top, meanings)
        notes.extend(why)
    if len(top) > 1 and quantity != "time":
        top, why = along_one_axis(top, meanings)
        notes.extend(why)
    if len(top) < 2 or _same_numbers(top):
        return top[0] if top else None
    if beside and quantity != "time":
        return None
    likely = _likely(top)
    leave = f", or leave it out with {ask(quantity, NONE)}" if quantity != "time" else ""
    doubts.append(
        f"{len(top)} {top[0].noun}s could be the {quantity}: {listed(top)}; "
        f"choose one, as in {ask(quantity, _name(likely))}{leave}{_or_runs(top)}"
    )
    return likely


def _or_runs(columns: Sequence[SourceColumn]) -> str:
    names = {split_unit(c.label)[0].rstrip("0123456789 _") for c in columns}
    return "; if they are releases of one rig, --run all" if len(names) == 1 and "" not in names else ""


def _likely(columns: Sequence[SourceColumn]) -> SourceColumn:
    """Return the column that oscillates most."""
    return max(columns, key=lambda c: (oscillation(c.values), -c.number))


def _same_numbers(columns: Sequence[SourceColumn]) -> bool:
    return all(np.array_equal(columns[0].values, c.values, equal_nan=True) for c in columns[1:])


def _name(column: SourceColumn) -> str:
    label = " ".join(column.label.split())
    return label if 0 < len(label) <= 30 else str(column.number)


def _what_is_not_said(rest: Sequence[SourceColumn]) -> str:
    if len(rest) == 1:
        return f"nothing says whether {rest[0].place} is a displacement, velocity or acceleration"
    return f"nothing says which {rest[0].noun} is a displacement, velocity or acceleration: {listed(rest)}"


def _of_unknown_kind(table: Table, rest: Sequence[SourceColumn], doubts: list[str]) -> SourceColumn:
    """Return the column that oscillates most, as a proposal. Raises ImportProblem where there is none beside the time."""
    rest = [c for c in rest if oscillation(c.values) > 0.0] or list(rest)
    if not rest:
        raise problem(
            table.path, "holds no column beside the time",
            "name a file with a displacement, velocity or acceleration",
        )  # fmt: skip
    likely = _likely(rest)
    doubts.append(
        f"{_what_is_not_said(rest)}; "
        f"say it and its unit (mm, deg, V ...), as in {ask('displacement', _name(likely))} --unit displacement=mm"
    )
    return likely
