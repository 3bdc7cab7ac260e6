"""The proposal for a file: a recipe, a sentence on each guess, and the questions that the file leaves open."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from types import MappingProxyType
from typing import cast

import numpy as np

from daq.importing.apply import ORDER, WIDE, stated
from daq.importing.bob import with_angle
from daq.importing.choose import choose_columns, left_out
from daq.importing.column_numbers import is_difference, is_offset
from daq.importing.columns import meaning
from daq.importing.errors import ImportProblem, problem
from daq.importing.options import NONE, QUANTITIES, ImportOptions, ask
from daq.importing.recipe import Column, Recipe, Role
from daq.importing.runs import find_runs, of_each
from daq.importing.table import SourceColumn, Table
from daq.importing.unit_of_column import is_angle, swings, too_far, unit_of, unit_of_angle
from daq.importing.units import SI_LINEAR, parse_scaled_unit
from daq.plain_text import one_line

DERIVATIVES = (
    ("displacement", "velocity", 1),
    ("velocity", "acceleration", 1),
    ("displacement", "acceleration", 2),
)


@dataclass(frozen=True)
class Proposal:
    """A recipe for a file. `notes` are what was understood and guessed of each run, by its name; `doubts` what somebody
    has to say or to confirm before the recipe is used, a sentence each.
    """

    recipe: Recipe
    notes: Mapping[str, tuple[str, ...]]
    doubts: tuple[str, ...] = ()


class Doubtful(ImportProblem):
    """A file of which something is to be said or confirmed first; `proposal` holds the doubts and a recipe, which is
    `settled` where it needs no more than to be confirmed.
    """

    def __init__(self, sentence: str, proposal: Proposal, *, settled: bool) -> None:
        super().__init__(sentence)
        self.proposal, self.settled = proposal, settled


@dataclass(frozen=True)
class _Run:
    table: Table
    columns: Mapping[str, SourceColumn]
    fields: tuple[Column, ...]
    notes: tuple[str, ...]
    doubts: tuple[str, ...]


@np.errstate(over="ignore", invalid="ignore")  # absurd numbers are refused where they are used
def propose(table: Table, options: ImportOptions) -> Proposal:
    """Return the recipe that the options, the headers and the numbers of a table suggest.

    Raises ImportProblem where an option contradicts the file, or nothing in it can be a motion.
    """
    found = find_runs(table, options)
    chosen = _chosen(table, found, options)
    widest = swings(chosen)
    made, left = of_each(chosen, lambda run: _settled(run, options, widest))
    derived = {} if options.keep_derived else _derived(made, options)
    notes = {run.table.run: (*run.notes[len(table.notes) :], *_left_out(run, derived), *left) for run in made}
    made = [replace(run, fields=tuple(f for f in run.fields if f.role not in derived)) for run in made]
    recipe = _recipe(table, made, options)
    return Proposal(recipe, MappingProxyType(notes), next((run.doubts for run in made if run.doubts), ()))


def _asked_run(options: ImportOptions) -> str:
    """Return the run that the operator named, "" for all."""
    text = str(options.run or "").strip().casefold()
    return "" if options.run is None or text == "all" else text.lstrip("#").lstrip("0") or "0"


def _chosen(table: Table, runs: list[Table], options: ImportOptions) -> list[Table]:
    """Return the run that the operator named, or all; where none has a name, it is one of those that the time begins."""
    wanted = _asked_run(options)
    found = [run for run in runs if run.run.casefold() == wanted] if wanted and runs[0].run else runs
    if not found:
        names = ", ".join(run.run for run in runs)
        raise problem(table.path, f"has no run '{options.run}'", f"it holds runs {names}")
    return found


def _recipe(table: Table, made: Sequence[_Run], options: ImportOptions) -> Recipe:
    """Join all runs into one recipe: a column has one role, in one run or in all."""
    roles: dict[int, Column] = {}
    for run in made:
        for field in run.fields:
            number = field.column or 0
            known = roles.get(number)
            if known is None:
                roles[number] = field.model_copy(update={"run": run.table.run})
            else:
                roles[number] = known.model_copy(update={"run": ""})
    found: dict[str, object] = {
        "format": table.format,
        "encoding": table.encoding,
        "stated": stated(table),
    }
    found |= {"dialect": table.dialect, "fields": _listed(table, roles)}
    if _asked_run(options) and not made[0].table.run:
        found |= {"restarts": True, "runs": (_asked_run(options),)}
    return options.as_recipe().model_copy(update=found)


def _listed(table: Table, roles: Mapping[int, Column]) -> tuple[Column, ...]:
    """Return the fields of a table by name, with their numbers where names do not tell them apart."""
    names = [one_line(c.label).strip() for c in table.columns]
    fields = []
    for column, name in zip(table.columns, names, strict=True):
        field = roles.get(column.number, Column(column=column.number))
        told = bool(name) and names.count(name) == 1
        if field.role != "ignored" or len(names) <= WIDE:
            number = None if told else column.number
            fields.append(field.model_copy(update={"name": name, "column": number}))
    return tuple(fields)


def _settled(run: Table, options: ImportOptions, widest: Mapping[str, float]) -> _Run:
    """Return the role of each column of a run; `widest` is how far columns swing in any run, by label."""
    table = with_angle(run, options)
    notes, doubts = list(table.notes), list(table.doubts)
    columns = choose_columns(table, options, notes, doubts)
    moved = columns.get("displacement")
    far = 0.0 if moved is None else widest.get(moved.label, 0.0)
    assumed = options.units.get("displacement", "rad" if moved is None else unit_of_angle(moved, far))
    default = assumed if is_angle(columns, options) else ""
    only = moved if columns.keys() <= {"time", "displacement"} else None
    if only is not None and options.columns and meaning(only.label, only.unit).quantity is None:
        default = default or "counts"  # nothing but an option says what it is
    beyond = "" if moved is None or default or "displacement" in options.units else too_far(moved, far)
    doubts += filter(None, [beyond])
    units = {}
    for q in (q for q in ORDER if q in columns):
        assumed = "counts" if beyond and q == "displacement" else default
        units[q] = unit_of(table, q, columns[q], options, assumed, notes)
    columns = _of_one_kind(columns, units, options, notes, doubts)
    if "time" in columns:
        if options.rate is not None:
            raise problem(table.path, "a time column and a rate were both given", "give one of them")
        units["time"] = unit_of(table, "time", columns["time"], options, "", notes)
    fields = {q: _fields(q, columns[q], unit) for q, unit in units.items() if q in columns}
    pull = columns.get("acceleration")
    if pull is not None and not options.keep_offset and is_offset(pull.values):
        fields["acceleration"] = (fields["acceleration"][0].model_copy(update={"zero": "median"}),)
        notes.append(
            f"{pull.place} swings about {float(np.nanmedian(pull.values)):.4g}, as gravity would have it: its "
            "median was taken out as an offset (--keep-offset keeps it)"
        )
    notes += filter(None, [left_out(table, columns)])
    listed = [field for several in fields.values() for field in several]
    return _Run(run, columns, tuple(listed), tuple(notes), tuple(doubts))


def _fields(quantity: str, column: SourceColumn, unit: str) -> tuple[Column, ...]:
    """Return the recipe's fields of a column: one, or the x and y of which it is the angle."""
    if column.arc is not None:
        x, y = column.arc
        return Column(column=x, role="x"), Column(column=y, role="y")
    return (Column(column=column.number, role=cast(Role, quantity), unit=unit),)


def _derived(runs: Sequence[_Run], options: ImportOptions) -> dict[str, str]:
    """Return the quantities that the logger computed from another channel, and why: what one run shows is true of all."""
    found: dict[str, str] = {}
    for run, (source, target, order) in product(runs, DERIVATIVES):
        one, two = run.columns.get(source), run.columns.get(target)
        if one is None or two is None or target in found:
            continue
        if is_difference(one.values, two.values, order):
            found[target] = f"its numbers are a finite difference of the {source}, not a sensor of its own"
        elif two.said.derived and target not in options.named:
            found[target] = f"its name says that it is derived, and the {source} is there"
    return found


def _left_out(run: _Run, derived: Mapping[str, str]) -> list[str]:
    """Return a sentence on each derived channel of a run."""
    return [
        f"{run.columns[quantity].place} was left out: {why} (--keep-derived keeps it)"
        for quantity, why in derived.items()
        if quantity in run.columns
    ]


def _of_one_kind(
    columns: Mapping[str, SourceColumn],
    spelled: Mapping[str, str],
    options: ImportOptions,
    notes: list[str],
    doubts: list[str],
) -> dict[str, SourceColumn]:
    """Leave out lengths beside an angle (or angles beside a length); it is a doubt where both or neither were asked for."""
    units = {q: parse_scaled_unit(text) or SI_LINEAR[q] for q, text in spelled.items()}
    kinds = [q for q in QUANTITIES[1:] if q in columns and units[q].quantity is not None]
    lead = next((q for q in kinds if q in options.named), kinds[0] if kinds else "")
    left = [q for q in kinds if units[q].angular != units[lead].angular]
    for quantity in left:
        said = f"{quantity} in {units[quantity].si} beside {lead} in {units[lead].si}"
        notes.append(f"{columns[quantity].place} was left out: {said} would mix an angle with a length")
        if (quantity in options.named) == (lead in options.named):
            doubts.append(f"mixes an angle with a length ({said}); leave one out ({ask(quantity, NONE)})")
    return {q: column for q, column in columns.items() if q not in left}
