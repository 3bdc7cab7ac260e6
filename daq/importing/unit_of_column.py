"""The unit of a column: what the operator or its header says, else what its numbers allow."""

from collections.abc import Mapping, Sequence

import numpy as np

from daq.importing.column_numbers import counts_rows, is_measurable
from daq.importing.columns import meaning
from daq.importing.errors import problem
from daq.importing.options import ImportOptions
from daq.importing.stamps import guess_time_unit
from daq.importing.table import SourceColumn, Table
from daq.importing.units import SI_ANGULAR, SI_LINEAR, parse_scaled_unit

DEGREES = {"displacement": "deg", "velocity": "deg/s", "acceleration": "deg/s^2"}
TURN = 2.0 * float(np.pi)
MOST_DEGREES = 720.0
"""No rig swings by more than two turns to either side: numbers beyond are an encoder's counts."""

MOST_METRES = 5.0
"""No rig swings by more metres to either side: such numbers are in another unit."""

_EXAMPLES = {
    "time": "s, ms, us", "displacement": "m, mm, um, in, rad, deg, V or a scale such as '0.0025 m'",
    "velocity": "m/s, mm/s, rad/s, deg/s, V", "acceleration": "m/s^2, g, rad/s^2, V", "force": "N, kN, N m, V",
}  # fmt: skip


def swings(tables: Sequence[Table]) -> dict[str, float]:
    """Return how far columns swing to either side by their labels, the most of all runs of a file: these have one unit."""
    found: dict[str, float] = {}
    for column in (c for table in tables for c in table.columns if c.bad is None):
        found[column.label] = max(found.get(column.label, 0.0), _swing(column))
    return found


def unit_of_angle(column: SourceColumn, far: float) -> str:
    """Return the unit of an angle that swings so `far`: where it names none, deg or counts beyond half a turn in rad, since
    few rigs swing so; others are in rad.
    """
    if not column.said.angular or column.said.unit is not None or far <= 0.5 * TURN:
        return "rad"
    return "deg" if far <= MOST_DEGREES else "counts"


def _swing(column: SourceColumn) -> float:
    """Return the swing of a column about its median, 0 without numbers of a sensible size."""
    finite = column.values[np.isfinite(column.values)]
    if not is_measurable(finite):
        return 0.0
    return float(np.percentile(np.abs(finite - np.median(finite)), 99.5))


def is_angle(columns: Mapping[str, SourceColumn], options: ImportOptions) -> bool:
    """Check whether channels without a unit are angles: an option's unit decides, else the headers."""
    asked = [parse_scaled_unit(text) for quantity, text in options.units.items() if quantity != "time"]
    known = [unit for unit in asked if unit is not None and unit.quantity is not None]
    return any(unit.angular for unit in known) if known else any(c.said.angular for c in columns.values())


def too_far(column: SourceColumn, far: float) -> str:
    """Return a sentence on a displacement that names no unit and swings so `far`, more than metres could, else ""."""
    if column.said.unit or far <= MOST_METRES:
        return ""
    return (
        f"{column.place} names no unit and swings by {far:.3g} to either side, too far for metres, so its "
        "numbers would be counts; say its unit, as in --unit displacement=deg"
    )


def unit_of(
    table: Table, quantity: str, column: SourceColumn, options: ImportOptions, default: str, notes: list[str]
) -> str:
    """Return the unit of a channel as it is spelled: from the options, the header, or SI by default, and note which.

    `default` is the unit of a displacement that names none, "" for m.
    """
    place, said, text = column.place, column.said, options.units.get(quantity)
    written = said.unit_text.replace("_s2", "/s^2").replace("_s", "/s")
    if text is not None:
        unit = parse_scaled_unit(text)
        if unit is None or unit.quantity not in (None, quantity):
            raise problem(
                table.path, f"'{text}' is no unit of {quantity} that is known here",
                f"give one of {_EXAMPLES[quantity]}",
            )  # fmt: skip
        other = said.unit is not None and said.unit != unit
        notes.append(
            f"{place} read as {quantity} in {text}, as asked"
            + (f", though its header says {written}" if other else "")
        )
        return text
    asked = ", chosen by the options" if quantity in options.named else ""
    if said.unit is not None:
        notes.append(f"{place} read as {quantity} in {written}{asked}")
        return said.unit_text
    if quantity == "time":
        says_so = meaning(column.label, column.unit).quantity == "time"
        if asked and not says_so and counts_rows(column.values):
            raise problem(
                table.path, f"{place} counts its rows, and nothing says how long one takes",
                "give --rate HZ in its place, or --unit time=ms",
            )  # fmt: skip
        spelled, why = guess_time_unit(column)
        assumed = f"; it names no unit: {why} (change it with --unit time=...)"
        notes.append(f"{place} read as time{'; times of day' if column.clock else assumed}")
        return spelled
    spelled = (SI_ANGULAR if default else SI_LINEAR)[quantity].si
    if default == "counts" and quantity == "displacement":
        spelled = "counts"
    elif quantity in DEGREES and default in ("deg", "\N{DEGREE SIGN}"):
        spelled = DEGREES[quantity]
    were = "were" if spelled == "counts" else "was"
    notes.append(
        f"{place} read as {quantity}{asked}; it names no unit: {spelled} {were} assumed "
        f"(change it with --unit {quantity}=...)"
    )
    return spelled
