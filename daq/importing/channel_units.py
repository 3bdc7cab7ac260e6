"""Units of the chosen columns: which they are in, and which go together."""

import numpy as np

from daq.importing.apply import ORDER
from daq.importing.choose import Choice
from daq.importing.errors import problem
from daq.importing.options import NONE, ImportOptions, ask
from daq.importing.table import Table
from daq.importing.units import SI_ANGULAR, SI_LINEAR, Unit, parse_scaled_unit, parse_unit

DEGREES = {"displacement": "deg", "velocity": "deg/s", "acceleration": "deg/s^2"}
FARTHEST = {"m": 20.0, "m/s^2": 1000.0}
"""What no displacement or acceleration reaches in SI: it is in counts, pixels or another unit."""


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


def unit_of(
    table: Table, choice: Choice, options: ImportOptions, turns: str, notes: list[str]
) -> tuple[Unit, str]:
    """Return the unit of a channel and its text: from the options, the header, or SI by default, and note which.

    `turns` is the unit of angles that name none, "" where the channels are none.
    """
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
        return unit, text
    asked = ", chosen by the options" if choice.asked else ""
    if choice.unit is not None:
        notes.append(f"{choice.column.place} read as {quantity} in {_spelled(choice.unit_text)}{asked}")
        return choice.unit, choice.unit_text
    unit = (SI_ANGULAR if turns else SI_LINEAR)[quantity]
    spelled, why, far = unit.si, "", _reach(choice)
    if quantity in DEGREES and turns in ("deg", "\N{DEGREE SIGN}"):
        spelled = DEGREES[quantity]
    elif far > FARTHEST.get(unit.si, np.inf) or (quantity == "displacement" and turns == "counts"):
        spelled = "counts"
    if spelled != unit.si:
        unit, why = parse_unit(spelled) or unit, f", for in {unit.si} {far:.3g} is more than rigs move by"
    notes.append(
        f"{choice.column.place} read as {quantity}{asked}; it names no unit: {spelled} was assumed{why} "
        f"(change it with --unit {quantity}=...)"
    )
    return unit, spelled


def _reach(choice: Choice) -> float:
    """Return how far a displacement moves, or how large another quantity gets, in the numbers of the file."""
    finite = choice.column.values[np.isfinite(choice.column.values)]
    if choice.column.bad is not None or not len(finite):
        return 0.0
    return float(np.ptp(finite)) if choice.quantity == "displacement" else float(np.max(np.abs(finite)))


def _spelled(text: str) -> str:
    """Return a unit as it is read: "m/s^2" for the "m_s2" of a header."""
    return text.replace("_s2", "/s^2").replace("_s", "/s")


def _unit_examples(quantity: str) -> str:
    examples = {
        "time": "s, ms, us", "displacement": "m, mm, um, in, rad, deg, V or a scale such as '0.0025 m'",
        "velocity": "m/s, mm/s, rad/s, deg/s, V", "acceleration": "m/s^2, g, rad/s^2, V", "force": "N, kN, N m, V",
    }  # fmt: skip
    return f"give one of {examples[quantity]}"


def of_one_kind(
    choices: dict[str, Choice], units: dict[str, Unit], notes: list[str], doubts: list[str]
) -> dict[str, Choice]:
    """Leave out lengths beside an angle (or angles beside a length); it is a doubt where somebody asked for them, or for
    none of them.
    """
    mechanical = [q for q in ORDER if q in choices and units[q].quantity is not None]
    lead = next((q for q in mechanical if choices[q].asked), mechanical[0] if mechanical else "")
    kept = dict(choices)
    for quantity in mechanical:
        if units[quantity].angular == units[lead].angular:
            continue
        del kept[quantity]
        said = f"{quantity} in {units[quantity].si} beside {lead} in {units[lead].si}"
        if not any(choices[q].asked for q in mechanical) or choices[quantity].asked:
            si = (SI_ANGULAR if units[lead].angular else SI_LINEAR)[quantity].si
            doubts.append(
                f"mixes an angle with a length ({said}); leave one out ({ask(quantity, NONE)}), or give a scale that makes "
                f"them alike, as in --unit {quantity}='4.0 {si}'"
            )
        else:
            notes.append(
                f"{choices[quantity].column.place} was left out: {said} would mix an angle with a length"
            )
    return kept
