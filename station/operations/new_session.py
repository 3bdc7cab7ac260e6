"""A new session: its folder, the facts about the specimen, and the settings of the capture."""

import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from daq.capture import CaptureSettings
from daq.importing.units import parse_scaled_unit, parse_unit
from daq.session_info import SessionInfo
from station.exits import UsageProblem
from station.settings import Settings
from station.suggestions import refusal

OF_THE_TEST = ("mass", "mass_std", "specimen", "operator", "conditions")
"""Options of a capture that go into the session's metadata."""


def new_folder(sessions: Path, prefix: str = "release") -> Path:
    """Return a folder for a new session, named by the time, that does not exist yet."""
    stamp = time.strftime("%Y%m%d_%H%M%S")
    folder, number = sessions / f"{prefix}_{stamp}", 1
    while folder.exists():
        number += 1
        folder = sessions / f"{prefix}_{stamp}_{number}"
    return folder


def session_info(
    settings: Settings,
    mass: float | None = None,
    mass_std: float | None = None,
    specimen: str | None = None,
    operator: str | None = None,
    conditions: tuple[str, ...] = (),
    varies: Sequence[str] = (),
) -> SessionInfo:
    """Return a session's metadata from options, else from the settings.

    `conditions` are numbers known of the test, each as "temperature [degC]=21.5".
    UsageProblem for a value that cannot be.
    """
    known = settings.specimen
    measured = dict(_condition(text) for text in conditions)
    try:
        return SessionInfo(
            operator=operator if operator is not None else known.operator,
            specimen=specimen if specimen is not None else known.name,
            mass_kg=mass if mass is not None else known.mass_kg,
            mass_std_kg=mass_std if mass is not None or mass_std is not None else known.mass_std_kg,
            conditions=measured,
            varies=tuple(name.strip() for name in varies if name.strip()),
        )
    except ValidationError as error:
        raise UsageProblem(f"{refusal(error).replace('_kg', ' [kg]').replace('_', ' ')}") from error


def _condition(text: str) -> tuple[str, float]:
    name, _, value = text.rpartition("=")
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    if not name.strip() or not math.isfinite(number):
        raise UsageProblem(f'--condition {text}: write NAME=NUMBER, as "temperature [degC]=21.5"')
    return name.strip(), number


def metres(text: str) -> float | None:
    """Read a length with its unit, such as 12mm; None where it is none."""
    length = parse_scaled_unit(text.strip())
    return (
        None if length is None or length.si != "m" or parse_unit(text.strip()) is not None else length.scale
    )


def capture_settings(settings: Settings, **given: Any) -> CaptureSettings:
    """Say how to capture, and what the session says of the test, by options of RELEASE, else by the settings."""
    release = given.get("release")
    if release is not None and (length := metres(release)) is None:
        raise UsageProblem(f"--release {release}: write a length with its unit, as 12mm or -8mm")
    known = settings.capture.model_copy(update={name: v for name, v in given.items() if v is not None})
    return CaptureSettings(
        duration_s=known.duration,
        rate_hz=known.rate,
        pre_trigger_s=known.pre_trigger,
        trigger_timeout_s=known.patience,
        trigger_level=given.get("level"),
        release_from=None if release is None else length,
        info=session_info(settings, **{name: given[name] for name in OF_THE_TEST if name in given}),
    )
