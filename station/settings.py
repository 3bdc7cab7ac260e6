"""Settings: what the operator writes once in station.toml and overrides by options."""

import tomllib
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from daq.port_names import fault_of
from station.exits import UsageProblem
from station.suggestions import read_named, refusal, shortened

DEFAULT_FILE = Path("station.toml")


def _port(name: str) -> str:
    if fault := fault_of(name):
        raise ValueError(fault)
    return name


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Specimen(_Section):
    """The specimen on the springs, and the operator."""

    operator: str = ""
    name: str = ""
    mass_kg: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    mass_std_kg: float | None = Field(default=None, ge=0, allow_inf_nan=False)


class Capture(_Section):
    """How a release is recorded: port, rate (Hz), duration after the release (s), patience (s)."""

    port: Annotated[str, AfterValidator(_port)] | None = None
    rate: float = Field(default=256.0, ge=5, le=20_000, allow_inf_nan=False)
    duration: float = Field(default=8.0, gt=0, le=3600, allow_inf_nan=False)
    pre_trigger: float = Field(default=1.0, ge=0.5, le=60, allow_inf_nan=False)
    patience: float = Field(default=60.0, gt=0, le=3600, allow_inf_nan=False)


class Identify(_Section):
    """How many orders of damping are tried, and which orders of stiffness the surface has."""

    max_order: int = Field(default=3, ge=0, le=5)
    stiffness_orders: tuple[int, ...] = (1,)


class Settings(_Section):
    """All settings, each with a default that suits the paper's testbed."""

    sessions: Path = Path("sessions")
    specimen: Specimen = Specimen()
    capture: Capture = Capture()
    identify: Identify = Identify()


def load_settings(file: str | Path | None) -> Settings:
    """Read settings from a TOML file; without one, ./station.toml if it exists, else the defaults.

    Raises UsageProblem that names the file and the entry that is wrong.
    """
    path = DEFAULT_FILE if file is None else Path(file)
    if file is None and not path.is_file():
        return Settings()
    try:
        content = tomllib.loads(read_named(path, "the settings").decode())
    except ValueError as error:  # not TOML, not UTF-8, or a number of thousands of digits
        raise UsageProblem(f"the settings {path} are not TOML: {shortened(str(error))}") from error
    except RecursionError as error:
        raise UsageProblem(f"the settings {path} are not TOML: they are nested too deeply") from error
    try:
        return Settings.model_validate(content)
    except ValidationError as error:
        sections = (Settings, Specimen, Capture, Identify)
        known = tuple(name for section in sections for name in section.model_fields)
        raise UsageProblem(f"the settings {path}: {refusal(error, known)}") from error


def version_of(package: str, missing: str) -> str:
    """Return the version of a package; `missing` where it runs without being installed."""
    try:
        return version(package)
    except PackageNotFoundError:
        return missing
