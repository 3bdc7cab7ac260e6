"""Units of the chosen columns: which they are in, which go together, and their numbers in SI."""

import numpy as np

from daq.importing.choose import LARGEST, Choice
from daq.importing.errors import problem
from daq.importing.options import NONE, ImportOptions, ask
from daq.importing.table import Table
from daq.importing.units import SI_ANGULAR, SI_LINEAR, Unit, parse_scaled_unit
from daq.recording import Array

FARTHEST = 20.0
ORDER = ("displacement", "velocity", "acceleration", "force")


def is_angle(choices: dict[str, Choice], options: ImportOptions) -> bool:
    """Return whether channels without a unit are angles: an option's unit decides, else the headers."""
    asked = [
        unit
        for q in ORDER
        if q in options.units and (unit := parse_scaled_unit(options.units[q])) is not None
    ]
    if any(unit.quantity is not None for unit in asked):
        return any(unit.angular for unit in asked)
    return any(choices[q].angular for q in ORDER if q in choices)


def unit_of(table: Table, choice: Choice, options: ImportOptions, angular: bool, notes: list[str]) -> Unit:
    """Return the unit of a channel: from the options, the header, or SI by default, and note which."""
    quantity, text = choice.quantity, options.units.get(choice.quantity)
    if text is not None:
        unit = parse_scaled_unit(text)
        if unit is None or unit.quantity not in (None, quantity):
            raise problem(
                table.path, f"'{text}' is no unit of {quantity} that is known here", _unit_examples(quantity)
            )
        other = choice.unit is not None and choice.unit != unit
        though = f", though its header says {_spelled(choice.unit_text)}" if other else ""
        notes.append(f"{choice.column.place} read as {quantity} in {text}, as asked{though}")
        return unit
    asked = ", chosen by the options" if choice.asked else ""
    if choice.unit is not None:
        notes.append(f"{choice.column.place} read as {quantity} in {_spelled(choice.unit_text)}{asked}")
        return choice.unit
    unit = (SI_ANGULAR if angular else SI_LINEAR)[quantity]
    notes.append(
        f"{choice.column.place} read as {quantity}{asked}; it names no unit: {unit.si} was assumed"
        f"{_though_far(choice, unit)} (change it with --unit {quantity}=...)"
    )
    return unit


def _though_far(choice: Choice, unit: Unit) -> str:
    """Return what speaks against metres, where a displacement goes further than any laboratory is long."""
    finite = choice.column.values[np.isfinite(choice.column.values)]
    far = float(np.ptp(finite)) if len(finite) and choice.column.bad is None else 0.0
    return f", though it moves by {far:.3g} m: pixels or mm?" if unit.si == "m" and far > FARTHEST else ""


def _spelled(text: str) -> str:
    """Return a unit as it is read: "m/s^2" for the "m_s2" of a header."""
    return text.replace("_s2", "/s^2").replace("_s", "/s")


def _unit_examples(quantity: str) -> str:
    examples = {
        "time": "s, ms, us", "displacement": "m, mm, um, in, rad, deg, V or a scale such as '0.0025 m'",
        "velocity": "m/s, mm/s, rad/s, deg/s, V", "acceleration": "m/s^2, g, rad/s^2, V", "force": "N, kN, N m, V",
    }  # fmt: skip
    return f"give one of {examples[quantity]}"


def without_empty(table: Table, choices: dict[str, Choice], notes: list[str]) -> dict[str, Choice]:
    """Leave out the columns that hold no number; ImportProblem for one that was asked for, or when none is left."""
    kept = {}
    for quantity, choice in choices.items():
        if choice.column.bad is None and not np.isfinite(choice.column.values).any():
            if quantity == "time" or choice.asked:
                raise problem(table.path, f"{choice.column.place} holds no numbers", "name another one")
            notes.append(f"{choice.column.place} holds no numbers and was left out")
            continue
        kept[quantity] = choice
    if not any(q in kept for q in ORDER[:3]):
        raise problem(table.path, "no channel holds numbers", "name another column or another file")
    return kept


def of_one_kind(
    table: Table, choices: dict[str, Choice], units: dict[str, Unit], notes: list[str]
) -> dict[str, Choice]:
    """Leave out lengths beside an angle (or angles beside a length) that nobody asked for; refuse those asked for."""
    mechanical = [q for q in ORDER if q in choices and units[q].quantity is not None]
    lead = next((q for q in mechanical if choices[q].asked), mechanical[0] if mechanical else "")
    kept = dict(choices)
    for quantity in mechanical:
        if units[quantity].angular == units[lead].angular:
            continue
        said = f"{quantity} in {units[quantity].si} beside {lead} in {units[lead].si}"
        if not any(choices[q].asked for q in mechanical) or choices[quantity].asked:
            raise problem(
                table.path, f"mixes an angle with a length ({said})",
                f"leave one out ({ask(quantity, NONE)}), or give a scale that makes them alike, "
                f"as in --unit {quantity}='4.0 {(SI_ANGULAR if units[lead].angular else SI_LINEAR)[quantity].si}'",
            )  # fmt: skip
        del kept[quantity]
        notes.append(
            f"{choices[quantity].column.place} was left out: {said} would mix an angle with a length"
        )
    return kept


def in_si(table: Table, choice: Choice, unit: Unit) -> Array:
    """Return a column in SI, shape (rows,), NaN where it is empty; ImportProblem for text or an impossible size."""
    column = choice.column
    if column.bad is not None:
        line, text = column.bad
        raise problem(
            table.path, f"'{text}' in {column.place} is not a number",
            "repair or remove the line, or choose another column", line=line, column=column.number,
        )  # fmt: skip
    with np.errstate(over="ignore", invalid="ignore"):
        values = column.values * unit.scale
    finite = np.isfinite(column.values)
    if np.any(np.abs(values[finite]) > LARGEST):
        row = int(np.flatnonzero(finite & ~(np.abs(values) <= LARGEST))[0])
        raise problem(
            table.path, f"{column.values[row]:.3g} is too large to be a measured {choice.quantity}",
            "repair or remove the line", line=table.line(row), column=column.number,
        )  # fmt: skip
    return np.where(np.isfinite(values), values, np.nan)
