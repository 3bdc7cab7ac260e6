"""Profiles: what the lines of a board mean, kept by name in a folder."""

import re
from pathlib import Path

from pydantic import ValidationError

from daq.errors import SettingsError
from daq.plain_text import first_fault
from daq.sources.line_format import LineFormat
from daq.storage import write_whole

BIGGEST = 1 << 20


def profile_file(name: str, folder: Path) -> Path:
    """Return the file of a profile. Raises SettingsError for a name that cannot be a file's."""
    if not re.fullmatch(r"[\w.-]{1,64}", name) or name.startswith("."):
        raise SettingsError(f"'{name}' is no name of a profile; use letters, digits, dots and dashes")
    return folder / f"{name}.json"


def save_profile(form: LineFormat, name: str, folder: Path) -> Path:
    """Write a profile and return its file; one of that name is replaced."""
    file = profile_file(name, folder)
    folder.mkdir(parents=True, exist_ok=True)
    write_whole(file, form.model_dump_json(indent=1).encode() + b"\n")
    return file


def load_profile(name: str, folder: Path) -> LineFormat:
    """Return a profile. Raises SettingsError where there is none, or it is damaged; the message lists those there are."""
    file = profile_file(name, folder)
    if not file.is_file():
        there = ", ".join(sorted(f.stem for f in folder.glob("*.json"))) or "none"
        raise SettingsError(
            f"there is no profile '{name}' in {folder} (there: {there}); make one with `station profile`"
        )
    try:
        if file.stat().st_size > BIGGEST:
            raise ValueError("too large")
        return LineFormat.model_validate_json(file.read_bytes())
    except (ValidationError, ValueError) as error:
        what = first_fault(error) if isinstance(error, ValidationError) else str(error)
        raise SettingsError(
            f"{file}: is no profile of lines ({what}); make it again with `station profile`"
        ) from error
