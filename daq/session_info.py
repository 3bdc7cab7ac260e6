"""What a session says about itself: `session.json`, checked when it is read."""

from datetime import UTC, datetime
from enum import StrEnum

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from daq.plain_text import Line

FORMAT = 1


class State(StrEnum):
    """Where a session stands."""

    RECORDING = "recording"
    SEALED = "sealed"
    RECOVERED = "recovered"
    ABORTED = "aborted"


class SensorInfo(BaseModel):
    """A sensor and its calibration: `uncertainty` is relative (0.01 is one per cent)."""

    model_config = ConfigDict(frozen=True)

    channel: Line = Field(max_length=255)
    sensor: Line = Field(default="", max_length=255)
    calibrated: Line = Field(default="", max_length=255)
    uncertainty: float | None = Field(default=None, ge=0, le=10, allow_inf_nan=False)


class BoardInfo(BaseModel):
    """Which board it was, as it said itself."""

    model_config = ConfigDict(frozen=True)

    board: Line = Field(default="", max_length=255)
    firmware: Line = Field(default="", max_length=255)
    unique_id: Line = Field(default="", max_length=255)
    boot_id: int = 0
    protocol: Line = Field(default="", max_length=16)


class SessionInfo(BaseModel):
    """The metadata of a session; SI units, the mass in kg (kg m^2 for angles).

    `source` is the port or the file, `noise` the standard deviation of each channel at rest in its unit,
    `rate_std_hz` the standard error of the rate (None where an import was given the rate), `reason` why a session was
    aborted or recovered. `conditions` are numbers known of the test, by name with their unit, as "temperature [degC]".
    `varies` names what differs between the sessions of one rig, as "stiffness" or "inertia".
    """

    model_config = ConfigDict(frozen=True, extra="ignore")

    format: int = Field(default=FORMAT, ge=1, le=FORMAT)
    name: Line = Field(default="", max_length=255)
    created: datetime = Field(default_factory=lambda: datetime.now(UTC).replace(microsecond=0))
    state: State = State.RECORDING
    operator: Line = Field(default="", max_length=255)
    specimen: Line = Field(default="", max_length=1000)
    remarks: str = Field(default="", max_length=10000)
    mass_kg: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    mass_std_kg: float | None = Field(default=None, ge=0, allow_inf_nan=False)
    sensors: tuple[SensorInfo, ...] = Field(default=(), max_length=256)
    source: Line = Field(default="", max_length=4096)
    source_file: str = Field(default="", max_length=255)
    board: BoardInfo | None = None
    rate_hz: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    rate_std_hz: float | None = Field(default=None, ge=0, allow_inf_nan=False)
    conditions: dict[Line, FiniteFloat] = Field(default_factory=dict, max_length=256)
    varies: tuple[Line, ...] = Field(default=(), max_length=64)
    planned_samples: int | None = Field(default=None, ge=0, le=1 << 53)
    noise: dict[str, float] = Field(default_factory=dict, max_length=256)
    verdict: Line = Field(default="", max_length=64)
    reason: Line = Field(default="", max_length=2000)
