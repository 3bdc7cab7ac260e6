"""The operator's statements about a file, where the file itself does not say."""

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from pydantic import ValidationError

from daq.importing.errors import ImportProblem
from daq.importing.recipe import Column, Part, Recipe
from daq.plain_text import first_fault
from daq.recording import MOTIONS

QUANTITIES = ("time", *MOTIONS, "force")
NONE = "none"


@dataclass(frozen=True)
class ImportOptions:
    """Choices that override what the importer finds out by itself; the default is to find out everything.

    `columns` maps a quantity (time, displacement, velocity, acceleration, force) to a column's name or
    1-based number; "none" leaves the quantity out. In a MATLAB file a column is a variable, in a UFF file
    a data set of type 58 (its number, its ID line, or its node and direction such as `3:+Z`).
    `units` maps a quantity to the unit of the numbers in the file, such as `mm`, `deg`, `g`, `V`, or a
    number and a unit for a sensor's scale, such as `0.0025 m`. `rate` (Hz) serves where there is no time column.
    `delimiter` (one character, or "blank", "tab"), `decimal` ("." or ","), `encoding` and `skip_rows`
    (lines to ignore at the top) are for text. `resample` puts samples with uneven time stamps on an even
    clock by a spline; `keep_derived` keeps a channel that was computed from another one.
    `run` is the run to read of a file that holds several. `accept` takes what is proposed where the file does not say all.
    `angle_from` names the columns of x and y from which an
    angle is to be taken, its zero hanging down. `start` and `stop` (s, as the file counts its time) cut the
    recording. `keep_offset` leaves gravity in an acceleration.

    Raises ImportProblem when an option contradicts itself.
    """

    columns: Mapping[str, str | int] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    rate: float | None = None
    delimiter: str | None = None
    decimal: str | None = None
    encoding: str | None = None
    skip_rows: int = 0
    resample: bool = False
    keep_derived: bool = False
    run: str | int | None = None
    angle_from: tuple[str, str] | None = None
    start: float | None = None
    stop: float | None = None
    keep_offset: bool = False
    accept: bool = False

    def __post_init__(self) -> None:
        for name, mapping in (("columns", self.columns), ("units", self.units)):
            for quantity in mapping:
                if quantity not in QUANTITIES:
                    raise ImportProblem(f"{name}: '{quantity}' is not one of {', '.join(QUANTITIES)}")
            object.__setattr__(self, name, MappingProxyType(dict(mapping)))
        if self.skip_rows < 0:
            raise ImportProblem(f"the number of rows to skip cannot be negative ({self.skip_rows})")
        if self.delimiter is not None and self.delimiter == self.decimal:
            raise ImportProblem(f"'{self.delimiter}' cannot be both the delimiter and the decimal sign")
        try:
            self.as_recipe()
        except ValidationError as error:
            raise ImportProblem(first_fault(error)) from None
        if self.angle_from is not None and "displacement" in self.columns:
            raise ImportProblem("an angle from two columns and a column of displacement were both asked for")

    @property
    def named(self) -> dict[str, str | int]:
        """The columns that are asked for, by their quantity, without those that are left out."""
        return {q: name for q, name in self.columns.items() if str(name).strip().lower() != NONE}

    def as_recipe(self) -> Recipe:
        """Return the dialect of the file, its rate, its part, and the columns that these choices ask for."""
        wanted = [str(name).strip() for name in self.named.values()]
        part = Part.model_validate({"from": self.start, "to": self.stop})
        return Recipe.model_validate(
            {
                "encoding": self.encoding,
                "rate": self.rate,
                "resample": self.resample,
                "parts": () if part == Part() else (part,),
                "dialect": {
                    "delimiter": self.delimiter,
                    "decimalChar": self.decimal,
                    "commentRows": range(1, self.skip_rows + 1),
                },
                "fields": [Column(name=name, role="displacement") for name in wanted if name],
            }
        )


def ask(quantity: str, column: object) -> str:
    """Return the option that names a column, as a shell takes it."""
    return f"--column {quantity}={shlex.quote(str(column))}"
