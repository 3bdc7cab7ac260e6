"""The base of all kept documents: numbers that JSON can hold, a version, one way to read and one to write."""

import math
from collections.abc import Callable
from typing import Annotated, Any, Literal, Self, TypeVar

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError
from pydantic_core import to_json, to_jsonable_python

from daq.errors import NotWritable, StorageError
from daq.session import Session
from daq.storage import digest
from identify.residual import residual_words
from station.exits import UsageProblem
from station.output import progress

LARGEST = 50 << 20

Content = TypeVar("Content")
Kept = TypeVar("Kept", bound="Document")

Number = Annotated[
    float | None, BeforeValidator(lambda n: None if isinstance(n, float) and not math.isfinite(n) else n)
]
"""A number; None where it is not finite, as JSON has no other way to say so."""

Numbers = Annotated[
    list[Number], BeforeValidator(lambda all: all.tolist() if isinstance(all, np.ndarray) else all)
]


class _Result:
    """A result with `others` beside its own attributes."""

    def __init__(self, result: object, others: dict[str, Any]) -> None:
        self._result, self._others = result, others

    def __getattr__(self, name: str) -> Any:
        return self._others[name] if name in self._others else getattr(self._result, name)


class Part(BaseModel):
    """A part of a document, made of the fields of a result; what another version added is passed over.

    Where a result has a field under another name, that is the `validation_alias`; a file has it under its own.
    """

    model_config = ConfigDict(
        extra="ignore", frozen=True, from_attributes=True, coerce_numbers_to_str=True, validate_by_name=True
    )

    @classmethod
    def of(cls, result: object, **others: Any) -> Self:
        """Make a part of the fields of a result, and of the `others`."""
        return cls.model_validate(_Result(result, others))

    def plain(self) -> dict[str, Any]:
        """Return the keys and values that `--json` prints."""
        return self.model_dump(mode="json")


class Document(Part):
    """A whole document; one without the version, or of another one, cannot be read."""

    format: Literal[1]


class EstimateDocument(Part):
    """A value with its standard error and its unit."""

    value: Number
    std: Number
    unit: str


class RefusedSession(Part):
    """A session without a result, and the reason."""

    session: str
    reason: str


class Errors(Part):
    """The three errors of a model, or of noise alone; None where one is not finite, or not known.

    `chi2_std` is the standard error of the floor of chi2; the free run goes to `horizon_s`.
    """

    force_mse_percent: Number = None
    motion_percent: Number = None
    chi2: Number = Field(None, validation_alias="chi_square")
    chi2_std: Number = Field(default=None, validation_alias="floor_std")
    horizon_s: Number = None

    @property
    def words(self) -> str:
        """The residual in % of the motion, and its rms over that of the noise."""
        return residual_words(self.motion_percent, self.chi2)


class ModelSummary(Part):
    """A model with its values."""

    effects: list[str] = Field(validation_alias="names")
    equation: str
    parameters: dict[str, EstimateDocument]


def picked(result: object, *names: str, **renamed: str) -> Any:
    """Pick values of a result by name, and under other names by those that it has for them; None without a result."""
    if result is None:
        return None
    return {
        own: getattr(result, name) for own, name in (dict(zip(names, names, strict=True)) | renamed).items()
    }


def plain(content: Content) -> Content:
    """Write values as JSON has them: results by their fields, arrays as lists, null for what is not finite."""
    made: Content = to_jsonable_python(content, inf_nan_mode="null", fallback=lambda array: array.tolist())
    return made


def read_document(session: Session, name: str, kind: type[Kept], remedy: str) -> Kept | None:
    """Return a result that a session keeps, None when it keeps none of that name.

    Raises UsageProblem, which ends with the `remedy`, when it was altered or another version wrote it.
    """
    found = read_with_checksum(session, name, kind, remedy)
    return None if found is None else found[0]


def read_with_checksum(session: Session, name: str, kind: type[Kept], remedy: str) -> tuple[Kept, str] | None:
    """Return a result as `read_document` does, and the checksum of its file."""
    try:
        content = session.read_result(name, LARGEST)
        return None if content is None else (kind.model_validate_json(content), digest(content))
    except (ValidationError, ValueError, StorageError) as error:
        raise UsageProblem(
            f"{session.folder.name}: results/{name} was altered, or another version wrote it; {remedy}"
        ) from error


def keep_document(
    session: Session, name: str, document: Document | dict[str, Any], tell: Callable[[str], None] = progress
) -> None:
    """Write a result, whatever stands there; where the session may not be written, `tell` gets a sentence."""
    try:
        session.write_result(name, to_text(document))
    except NotWritable as error:
        tell(f"note: {error}; what is found is not kept")


def to_text(document: BaseModel | dict[str, Any]) -> str:
    """Write a document as the text of its file."""
    return to_json(document, indent=2).decode() + "\n"


def seen(session: Session, name: str) -> str | None:
    """Return the checksum of a result's file, readable or not; None where there is no file."""
    content = session.read_result(name, LARGEST)
    return None if content is None else digest(content)
