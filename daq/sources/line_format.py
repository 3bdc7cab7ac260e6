"""Which column of a board's lines is what: told by options or a profile, or found from names and from the numbers."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from daq.errors import OperatorError
from daq.importing.columns import INDEX, meaning, words
from daq.importing.options import NONE, QUANTITIES, ask
from daq.importing.units import SI_ANGULAR, SI_LINEAR, Unit, parse_scaled_unit
from daq.plain_text import first_fault
from daq.recording import Array, Channel
from daq.storage import write_whole

COUNTER = "counter"
UNUSED = "unused"
BIGGEST_PROFILE = 1 << 20
CLOCKS = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
ALIKE = 0.25
"""Relative difference between a column's steps and the arrivals up to which it may be a time in that unit."""


class LineChannel(BaseModel):
    """One channel: its column, and `value = scale * number` in `unit` (SI)."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    column: str = Field(max_length=255)
    name: str = Field(max_length=255)
    quantity: str = Field(pattern="^(displacement|velocity|acceleration|force)$")
    unit: str = Field(max_length=24)
    scale: float = Field(allow_inf_nan=False)

    def channel(self) -> Channel:
        """Return the channel of a recording."""
        return Channel(self.name, self.quantity, self.unit)


class LineClock(BaseModel):
    """What tells when a line's sample was taken: its stamp (numbers times `scale` are s), its counter, or its arrival."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    kind: Literal["stamps", "counter", "arrival"]
    column: str | None = None
    scale: float = Field(default=1.0, gt=0, allow_inf_nan=False)

    @model_validator(mode="after")
    def _has_its_column(self) -> Self:
        if (self.kind == "arrival") != (self.column is None):
            raise ValueError(f"a clock by {self.kind} and column {self.column}")
        return self


class LineFormat(BaseModel):
    """What the lines of a board mean; kept as a profile.

    `names` are those of separated columns, in order, where a header gave them. `rate_hz` is the rate where it is known.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    channels: tuple[LineChannel, ...] = Field(min_length=1, max_length=64)
    clock: LineClock
    names: tuple[str, ...] = Field(default=(), max_length=64)
    rate_hz: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    baud: int | None = Field(default=None, gt=0)

    @property
    def columns(self) -> tuple[str, ...]:
        """All columns that are read, the clock's last."""
        clock = () if self.clock.column is None else (self.clock.column,)
        return (*(c.column for c in self.channels), *clock)


class Sample(BaseModel):
    """Lines that were listened to: columns by name, each (n,), when each line arrived (n,), s, and the last as it came."""

    model_config = ConfigDict(frozen=True, arbitrary_types_allowed=True)

    columns: dict[str, Array]
    arrivals: Array
    header: tuple[str, ...] = ()
    text: str = ""


def find_format(
    sample: Sample,
    columns: Mapping[str, str | int] | None = None,
    units: Mapping[str, str] | None = None,
    rate_hz: float | None = None,
) -> LineFormat:
    """Decide the meaning of the lines.

    `columns` maps time, counter, displacement, velocity, acceleration, force to a column's name or number ("none"
    leaves it out), and "unused" to one that is none of them, `units` a quantity to its unit or its scale with a unit
    ("0.0049 mm"). Raises OperatorError where no column is a motion, a unit is not known, or a comma may be a column's end or
    a decimal comma; the message lists what comes.
    """
    wanted = {quantity: str(column) for quantity, column in (columns or {}).items()}
    for name in (*wanted, *(units or {})):
        if name not in (*QUANTITIES, COUNTER, UNUSED):
            raise OperatorError(
                f"'{name}' is no quantity; there are {', '.join((*QUANTITIES, COUNTER, UNUSED))}"
            )
    lines = _Lines(sample, wanted, units or {})
    motions = lines.motions()
    used = [motion.column for motion in motions]
    clock = lines.clock([c for c in sample.columns if c not in used])
    if UNUSED not in lines.chosen:
        _refuse_decimal_commas(sample, clock.column, used)
    return LineFormat(channels=motions, names=lines.names, rate_hz=rate_hz, clock=clock)


def describe_columns(sample: Sample) -> str:
    """Return the columns with the range of their numbers, for a sentence."""
    label = dict(zip(sample.columns, sample.header, strict=False))
    said = [
        f"{label.get(name, name)} ({np.nanmin(values):.6g} to {np.nanmax(values):.6g})"
        for name, values in sample.columns.items()
        if np.isfinite(values).any()
    ]
    return ", ".join(said) or "none with numbers"


def _refuse_decimal_commas(sample: Sample, clock: str | None, used: Sequence[str]) -> None:
    """Raise OperatorError where each second column may be the decimals of the one before it: nothing else reads it."""
    fields = dict(zip(sample.columns, sample.text.split(","), strict=False))
    fields.pop(clock or "", None)
    whole, decimals = list(fields.values())[::2], list(fields)[1::2]
    if (
        len(sample.text.split(",")) != len(sample.columns)
        or len(whole) != len(decimals)
        or set(decimals) & set(used)
    ):
        return
    if all(text.strip().lstrip("+-").isdecimal() for text in whole) and all(
        fields[c].isdecimal() for c in decimals
    ):
        raise OperatorError(
            f"'{sample.text[:40]}' may be {len(decimals)} with a decimal comma or {len(fields)} columns, each second one"
            f" unused; print a decimal point, or say that they are columns, as {ask(UNUSED, decimals[0])}"
        )


class _Lines:
    """Lines that were listened to, and what is told of them: `chosen` columns by quantity, and quantities `left_out`."""

    def __init__(self, sample: Sample, wanted: Mapping[str, str], units: Mapping[str, str]) -> None:
        self.names = sample.header if len(sample.header) == len(sample.columns) else ()
        self._sample, self._units = sample, units
        self._label = dict(zip(sample.columns, self.names, strict=False))
        self._left_out = {q for q, name in wanted.items() if name.lower() == NONE}
        self.chosen = {q: self._column(q, name) for q, name in wanted.items() if q not in self._left_out}

    def _column(self, quantity: str, name: str) -> str:
        columns = list(self._sample.columns)
        at = dict(zip(self.names, columns, strict=False)) | {column: column for column in columns}
        if name in at:
            return at[name]
        if name.isdigit() and 1 <= int(name) <= len(columns):
            return columns[int(name) - 1]
        raise OperatorError(
            f"{quantity}: there is no column '{name}'; what comes is {describe_columns(self._sample)}"
        )

    def _header(self, column: str) -> str:
        return self._label.get(column, column)

    def motions(self) -> tuple[LineChannel, ...]:
        """Return the channels: the columns that were chosen, and the first whose name says another quantity."""
        found = dict(self.chosen)
        for column in [c for c in self._sample.columns if c not in self.chosen.values()]:
            said = meaning(self._header(column))
            if said.quantity in QUANTITIES[1:] and said.quantity not in (*found, *self._left_out):
                found[said.quantity] = column
        motions = []
        for quantity in [q for q in QUANTITIES[1:] if q in found]:
            column = found[quantity]
            unit = _unit(quantity, self._header(column), self._units.get(quantity))
            name = self._label.get(column, quantity if column.isdigit() else column)
            motions.append(
                LineChannel(column=column, name=name, quantity=quantity, unit=unit.si, scale=unit.scale)
            )
        if not any(m.quantity != "force" for m in motions):
            raise OperatorError(
                f"no column is known to be a motion; what comes is {describe_columns(self._sample)}. Say which one is, as "
                "--column displacement=2 --unit displacement='0.005 mm' (what one count is)"
            )
        return tuple(motions)

    def clock(self, free: Sequence[str]) -> LineClock:
        """Return the clock: stamps where a `free` column is a time, else a counter, else arrivals."""
        if "time" in self.chosen:
            return self._stamps(self.chosen["time"], asked=True) or LineClock(kind="arrival")
        if COUNTER in self.chosen:
            return LineClock(kind="counter", column=self.chosen[COUNTER])
        named_first = sorted(free, key=lambda c: meaning(self._header(c)).quantity != "time")
        for column in named_first if "time" not in self._left_out else []:
            if (found := self._stamps(column, asked=False)) is not None:
                return found
        for column in free if COUNTER not in self._left_out else []:
            if _counts(self._sample.columns[column]):
                return LineClock(kind="counter", column=column)
        return LineClock(kind="arrival")

    def _stamps(self, column: str, *, asked: bool) -> LineClock | None:
        """Return a clock by stamps if a column's steps are the arrivals' in some unit of time; a counter's may be, too."""
        values, arrivals = self._sample.columns[column], self._sample.arrivals
        said, given = meaning(self._header(column)), self._units.get("time")
        scale = None
        if given is not None:
            unit = parse_scaled_unit(given)
            if unit is None or unit.si != "s":
                raise OperatorError(f"time: '{given}' is no unit of time; say s, ms or us")
            scale = unit.scale
        elif said.unit is not None and said.unit.quantity == "time":
            scale = said.unit.scale
        span = float(arrivals[-1] - arrivals[0])
        rises = bool(np.isfinite(values).all() and (np.diff(values) >= 0).all() and values[-1] > values[0])
        if scale is None and rises and span > 0:
            fits = [s for s in CLOCKS.values() if abs((values[-1] - values[0]) * s / span - 1) < ALIKE]
            plain_counter = set(words(self._header(column))) & INDEX and _counts(values)
            scale = fits[0] if fits and not (plain_counter and not asked) else None
        if scale is None and asked:
            raise OperatorError(f"time: the unit of column '{column}' is not known; say --unit time=ms")
        if scale is None or not (asked or rises):
            return None
        return LineClock(kind="stamps", column=column, scale=scale)


def _unit(quantity: str, header: str, given: str | None) -> Unit:
    said = meaning(header)
    if given is not None:
        unit = parse_scaled_unit(given)
        if unit is None or unit.quantity not in (quantity, None):
            raise OperatorError(
                f"{quantity}: '{given}' is no unit of a {quantity}; say mm, deg, g, or '0.005 mm'"
            )
        return unit
    if said.unit is not None and said.unit.quantity == quantity:
        return said.unit
    raise OperatorError(
        f"{quantity}: the unit of column '{header}' is not known; say it, as --unit {quantity}=mm, or what one count "
        f"is, as --unit {quantity}='0.005 {(SI_ANGULAR if said.angular else SI_LINEAR)[quantity].si}'"
    )


def _counts(values: Array) -> bool:
    """Check whether a column counts the lines: steps of one, but where it begins anew or lines were lost."""
    steps = np.diff(values)
    return bool(len(steps) > 8 and np.isfinite(values).all() and np.mean(steps == 1.0) > 0.9)


def profile_file(name: str, folder: Path) -> Path:
    """Return the file of a profile. Raises OperatorError for a name that cannot be a file's."""
    if not re.fullmatch(r"[\w.-]{1,64}", name) or name.startswith("."):
        raise OperatorError(f"'{name}' is no name of a profile; use letters, digits, dots and dashes")
    return folder / f"{name}.json"


def save_profile(form: LineFormat, name: str, folder: Path) -> Path:
    """Write a profile and return its file; one of that name is replaced."""
    file = profile_file(name, folder)
    folder.mkdir(parents=True, exist_ok=True)
    write_whole(file, form.model_dump_json(indent=1).encode() + b"\n")
    return file


def load_profile(name: str, folder: Path) -> LineFormat:
    """Return a profile. Raises OperatorError where there is none, or it is damaged; the message lists those there are."""
    file = profile_file(name, folder)
    if not file.is_file():
        there = ", ".join(sorted(f.stem for f in folder.glob("*.json"))) or "none"
        raise OperatorError(
            f"there is no profile '{name}' in {folder} (there: {there}); make one with `station profile`"
        )
    try:
        if file.stat().st_size > BIGGEST_PROFILE:
            raise ValueError("too large")
        return LineFormat.model_validate_json(file.read_bytes())
    except ValueError as error:
        what = first_fault(error) if isinstance(error, ValidationError) else str(error)
        raise OperatorError(
            f"{file}: is no profile of lines ({what}); make it again with `station profile`"
        ) from error
