"""Changes to a kept session: its name, its notes, facts about the specimen; and the bin."""

import os
import re
import time
from pathlib import Path
from typing import Any

from daq.errors import StationError
from daq.session import Session
from daq.storage import Lock
from station.exits import UsageProblem

BIN = ".bin"
LONGEST = 100
"""Letters of a name."""


def plain_name(given: str) -> str:
    """Return the last part of a name with letters, digits, dots and dashes only; "recording" where nothing is left."""
    last = re.split(r"[/\\]", given)[-1]
    stem, dot, ending = last.rpartition(".")
    if not dot:
        stem, ending = last, ""
    stem = re.sub(r"[^\w.-]+", "_", stem).strip("._")[:LONGEST] or "recording"
    ending = re.sub(r"[^A-Za-z0-9]+", "", ending)[:10]
    return f"{stem}.{ending}" if ending else stem


def rename(folder: Path, wanted: str) -> Path:
    """Give a session and its folder another name; UsageProblem where that is none, or is taken."""
    name = plain_name(re.sub(r"[/\\]", "_", wanted)) if wanted.strip() else ""
    if not name:
        raise UsageProblem("a session needs a name of letters, digits, dots and dashes")
    place = folder.with_name(name)
    if place == folder:
        return folder
    if place.exists():
        raise UsageProblem(f"there is a session called {name} already")
    _move(folder, place)
    Session.open(place).update(name=name)
    return place


def describe(folder: Path, **changes: Any) -> None:
    """Change what a session says of itself: `remarks`, `specimen`, `operator`, `mass_kg` (kg).

    Raises UsageProblem where a value is out of range.
    """
    if "mass_kg" in changes and changes["mass_kg"] is not None and not changes["mass_kg"] > 0:
        raise UsageProblem(f"the mass must be more than 0 kg, not {changes['mass_kg']:g} kg")
    try:
        Session.open(folder).update(**changes)
    except StationError as error:
        raise UsageProblem(f"{folder.name} was not changed: {error}") from error


def to_bin(folder: Path) -> Path:
    """Move a session into the bin beside it, from which it can be taken back by hand; return where it is now."""
    place = folder.parent / BIN / f"{folder.name}_{time.strftime('%Y%m%d_%H%M%S')}"
    place.parent.mkdir(exist_ok=True)
    _move(folder, place)
    return place


def _move(folder: Path, place: Path) -> None:
    try:
        lock = Lock(folder)
        lock.acquire()
        lock.release()
    except StationError as error:
        raise UsageProblem(f"{folder.name} is being written; wait until it is sealed") from error
    try:
        os.rename(folder, place)
    except OSError as error:
        raise UsageProblem(f"{folder.name} was not moved: {error.strerror or error}") from error
