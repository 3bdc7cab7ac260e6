"""Units of the chosen columns: which they are in, and which go together."""

from collections.abc import Mapping, Sequence

import numpy as np

from daq.importing.choose import Choice
from daq.importing.column_numbers import is_measurable
from daq.importing.columns import meaning
from daq.importing.errors import problem
from daq.importing.options import NONE, QUANTITIES, ImportOptions, ask
from daq.importing.table import SourceColumn, Table
from daq.importing.units import SI_ANGULAR, SI_LINEAR, Unit, parse_scaled_unit, parse_unit

DEGREES = {"displacement": "deg", "velocity": "deg/s", "acceleration": "deg/s^2"}
TURN = 2.0 * float(np.pi)
MOST_DEGREES = 720.0
"""No rig swings by more than two turns to either side: numbers beyond are an encoder's counts."""


def units_of_angles(tables: Sequence[Table]) -> dict[str, str]:
    """Return the unit of angles that name none by their labels, one for all runs of a file: deg or counts where one run
    swings by more than half a turn in rad to either side, since few rigs do; others are in rad.
    """
    swings: dict[str, float] = {}
    for column in (c for table in tables for c in table.columns if c.bad is None):
        said = meaning(column.label, column.unit)
        if said.quantity == "displacement" and said.angular and said.unit is None:
            swings[column.label] = max(swings.get(column.label, 0.0), _swing(column))
    return {k: "deg" if far <= MOST_DEGREES else "counts" for k, far in swings.items() if far > 0.5 * TURN}


def _swing(column: SourceColumn) -> float:
    """Return the swing of a column about its median, 0 without numbers of a sensible size."""
    finite = column.values[np.isfinite(column.values)]
    if not is_measurable(finite):
        return 0.0
    return float(np.percentile(np.abs(finite - np.median(finite)), 99.5))


def is_angle(choices: Mapping[str, Choice], options: ImportOptions) -> bool:
    """Check whether channels without a unit are angles: an option's unit decides, else the headers."""
    asked = [parse_scaled_unit(text) for quantity, text in options.units.items() if quantity != "time"]
    known = [unit for unit in asked if unit is not None and unit.quantity is not None]
    return any(unit.angular for unit in known) if known else any(c.said.angular for c in choices.values())


def unit_of(
    table: Table, choice: Choice, options: ImportOptions, turns: str, notes: list[str]
) -> tuple[Unit, str]:
    """Return the unit of a channel and its text: from the options, the header, or SI by default, and note which.

    `turns` is the unit of angles that name none, "" where the channels are none.
    """
    quantity, place, text = choice.quantity, choice.column.place, options.units.get(choice.quantity)
    written = choice.said.unit_text.replace("_s2", "/s^2").replace("_s", "/s")
    if text is not None:
        unit = parse_scaled_unit(text)
        if unit is None or unit.quantity not in (None, quantity):
            raise problem(
                table.path, f"'{text}' is no unit of {quantity} that is known here",
                f"give one of {_EXAMPLES[quantity]}",
            )  # fmt: skip
        other = choice.said.unit is not None and choice.said.unit != unit
        notes.append(
            f"{place} read as {quantity} in {text}, as asked"
            + (f", though its header says {written}" if other else "")
        )
        return unit, text
    asked = ", chosen by the options" if choice.asked else ""
    if choice.said.unit is not None:
        notes.append(f"{place} read as {quantity} in {written}{asked}")
        return choice.said.unit, choice.said.unit_text
    spelled = (SI_ANGULAR if turns else SI_LINEAR)[quantity].si
    if turns == "counts" and quantity == "displacement":
        spelled = "counts"
    elif quantity in DEGREES and turns in ("deg", "\N{DEGREE SIGN}"):
        spelled = DEGREES[quantity]
    notes.append(
        f"{place} read as {quantity}{asked}; it names no unit: {spelled} was assumed (change it with --unit {quantity}=...)"
    )
    return parse_unit(spelled) or SI_LINEAR[quantity], spelled


_EXAMPLES = {
    "time": "s, ms, us", "displacement": "m, mm, um, in, rad, deg, V or a scale such as '0.0025 m'",
    "velocity": "m/s, mm/s, rad/s, deg/s, V", "acceleration": "m/s^2, g, rad/s^2, V", "force": "N, kN, N m, V",
}  # fmt: skip


def of_one_kind(
    choices: Mapping[str, Choice], units: Mapping[str, Unit], notes: list[str], doubts: list[str]
) -> dict[str, Choice]:
    """Leave out lengths beside an angle (or angles beside a length); it is a doubt where both or neither were asked for."""
    kinds = [q for q in QUANTITIES[1:] if q in choices and units[q].quantity is not None]
    lead = next((q for q in kinds if choices[q].asked), kinds[0] if kinds else "")
    left = [q for q in kinds if units[q].angular != units[lead].angular]
    for quantity in left:
        said = f"{quantity} in {units[quantity].si} beside {lead} in {units[lead].si}"
        notes.append(
            f"{choices[quantity].column.place} was left out: {said} would mix an angle with a length"
        )
        if choices[quantity].asked == choices[lead].asked:
            doubts.append(f"mixes an angle with a length ({said}); leave one out ({ask(quantity, NONE)})")
    return {q: choice for q, choice in choices.items() if q not in left}
