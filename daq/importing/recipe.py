"""A recipe: how a file is to be read, as people write it and as an import keeps it (docs/importing.md shows one).

Words of the Data Package standard (Table Dialect 2.0, Table Schema) where it has them; TOML on disk.
"""

import json
import tomllib
from pathlib import Path
from typing import Annotated, Any, Final, Literal, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    FiniteFloat,
    ValidationError,
    model_validator,
)

from daq.importing.errors import LONGEST_NAME, MAX_COLUMNS, MAX_LINES, MAX_RECIPE, problem, require_size
from daq.importing.units import parse_scaled_unit
from daq.plain_text import Line, first_fault

Role = Literal[
    "time", "time_step", "run", "displacement", "velocity", "acceleration", "force", "x", "y", "ignored"
]
ROLES: Final = get_args(Role)
Format = Literal["text", "serial", "json", "matlab", "uff"]
Name = Annotated[Line, Field(max_length=LONGEST_NAME)]
Row = Annotated[int, Field(ge=1, le=MAX_LINES)]
Rate = Annotated[float, Field(gt=0.0, lt=1e9)]
SPELLED: Final = {"tab": "\t", "\\t": "\t", "blank": " ", "space": " "}


def _sign(said: str) -> str:
    if len(sign := SPELLED.get(said, said)) != 1:
        raise ValueError(f"the delimiter must be one character, 'tab' or 'blank', not {said[:40]!r}")
    return sign


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True)


class Dialect(_Part):
    """How a text is written (Table Dialect 2.0); what is not said is found out. Rows count from 1.

    `decimalChar` is Table Schema's word, said here once for all fields. Of JSON, `property` is the key of the table, with
    points between the keys on the way.
    """

    header: bool = True
    comment_rows: tuple[Row, ...] = Field(default=(), alias="commentRows")
    delimiter: Annotated[str, AfterValidator(_sign)] | None = None
    decimal_char: Literal[".", ","] | None = Field(default=None, alias="decimalChar")
    property: str | None = Field(default=None, max_length=LONGEST_NAME)


class Column(_Part):
    """A column (Table Schema's field): its `name`, its number from 1 where the name does not tell it apart, what it is.

    A number of the file, counted on where numbers begin again after `wraps`, less `zero`, times `sign`, is in `unit` (SI
    without one). `zero` may be the record's median. Of `x` and `y` of a bob the angle is taken, about the pivot that
    `zero` gives, else about the centre of their arc. A column belongs to one `run`, or to all.
    """

    name: Name = ""
    column: int | None = Field(default=None, ge=1, le=MAX_COLUMNS)
    role: Role = "ignored"
    unit: str = Field(default="", max_length=60)
    sign: Literal[1, -1] = 1
    zero: FiniteFloat | Literal["median"] | None = None
    wraps: FiniteFloat | None = Field(default=None, gt=0.0)
    run: Name = ""

    @model_validator(mode="after")
    def _is_known(self) -> "Column":
        unit = parse_scaled_unit(self.unit) if self.unit else None
        quantity = {"time_step": "time", "x": "displacement", "y": "displacement"}.get(self.role, self.role)
        if (
            self.unit
            and self.role not in ("ignored", "run")
            and (unit is None or unit.quantity not in (None, quantity))
        ):
            raise ValueError(f"'{self.unit}' is no unit of {quantity} that is known here")
        if not self.name and self.column is None:
            raise ValueError("a field needs a name, or column, its number from 1")
        return self


class Part(_Part):
    """A part of the record to be read, in the time of the file (s)."""

    start: FiniteFloat | None = Field(default=None, alias="from")
    stop: FiniteFloat | None = Field(default=None, alias="to")

    @model_validator(mode="after")
    def _goes_on(self) -> "Part":
        if self.start is not None and self.stop is not None and not self.start < self.stop:
            raise ValueError(f"a part cannot end at {self.stop:g} s and begin at {self.start:g} s")
        return self


class Recipe(_Part):
    """All that is needed to read a file of one shape; `recipe` is the version of this form.

    `confirmed` says that a person has looked at it: it is used again for the next file with these fields. `rate` (Hz) takes
    the place of time stamps; `even` rows were read at the mean rate of their stamps, however these stray. `restarts` cuts
    the rows where the time begins again; `runs` names those to read, all without.
    `stated` are the units that the file itself writes above its numbers: where they are others, it is another logger's file.
    """

    recipe: Literal[1] = 1
    format: Format | None = None
    confirmed: bool = False
    encoding: str | None = Field(default=None, max_length=40)
    rate: Rate | None = None
    resample: bool = False
    even: bool = False
    restarts: bool = False
    runs: tuple[Name, ...] = Field(default=(), max_length=MAX_COLUMNS)
    stated: tuple[Name, ...] | None = Field(default=None, max_length=MAX_COLUMNS)
    parts: tuple[Part, ...] = Field(default=(), max_length=100)
    dialect: Dialect = Dialect()
    fields: tuple[Column, ...] = Field(default=(), max_length=MAX_COLUMNS)


def read_recipe(path: Path) -> Recipe:
    """Return the recipe in a TOML file. Raises ImportProblem, one sentence, where it is none."""
    try:
        if not path.is_file():
            raise problem(path, "is no file", "name a recipe, as an import writes it")
        require_size(path, path.stat().st_size, MAX_RECIPE)
        return Recipe.model_validate(tomllib.loads(path.read_text(encoding="utf-8")))
    except OSError as error:
        raise problem(path, f"the recipe cannot be read ({error.strerror})", "check its name") from None
    except ValidationError as error:
        raise problem(path, first_fault(error), "see the form in docs/importing.md") from None
    except (ValueError, RecursionError) as error:
        raise problem(path, f"is no recipe in TOML ({error})", "repair it, or import without it") from None


def to_toml(recipe: Recipe) -> str:
    """Return a recipe as TOML, a line for each field; what is as it is without being said is left out."""
    said = recipe.model_dump(mode="json", by_alias=True, exclude_defaults=True)
    dialect = said.pop("dialect", {})
    lines = ["recipe = 1"]
    for key, value in said.items():
        several = isinstance(value, list) and value and isinstance(value[0], dict)
        rows = "".join(f"  {_toml(row)},\n" for row in value) if several else ""
        lines.append(f"{key} = [\n{rows}]" if several else f"{key} = {_toml(value)}")
    if dialect:
        lines += ["[dialect]", *(f"{key} = {_toml(value)}" for key, value in dialect.items())]
    return "\n".join(lines) + "\n"


def _toml(value: Any) -> str:
    """Return a value as TOML writes it: JSON, but for tables."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_toml(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
