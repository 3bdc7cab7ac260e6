"""The sessions of a campaign: those in a folder, or those that were named."""

import hashlib
import json
from dataclasses import asdict
from pathlib import Path

from daq.errors import StationError
from daq.session import Session, SessionSummary, list_sessions
from daq.session_info import State
from daq.session_reading import INFO, RAW
from daq.storage import read_regular
from station.campaign.work import Work
from station.exits import UsageProblem
from station.results.sessions import open_session
from station.settings import Settings, version_of
from station.story.preparation import options_for

LARGEST = 1 << 30
DISTRIBUTION = "free-decay-station"
FOLDER = "campaign"


def work_on(folder: Path, settings: Settings, diagnose: bool) -> Work:
    """Make the work on a session; StationError when its files cannot be read, or are still written.

    The key is a checksum of all that the result depends on: readings, calibrations, options, the
    program. What else the metadata say is read afresh for every table.
    """
    session = Session.open(folder)
    if session.info.state is State.RECORDING:
        raise StationError("it is being recorded, or was cut off: wait, or seal it by `station recover`")
    options = options_for(session, settings)
    dependent = {
        "sensors": [sensor.model_dump(mode="json") for sensor in session.info.sensors],
        "rate_std_hz": session.info.rate_std_hz,
        "options": asdict(options),
        "diagnose": diagnose,
        "program": version_of(DISTRIBUTION, ""),
    }
    checksum = hashlib.sha256(json.dumps(dependent, sort_keys=True).encode())
    checksum.update(hashlib.sha256(read_regular(folder / RAW, LARGEST)).digest())
    return Work(folder, checksum.hexdigest(), options, diagnose)


def find_sources(arguments: tuple[str, ...], settings: Settings) -> tuple[SessionSummary, ...]:
    """Return the sessions that are meant, each once, oldest first in a folder.

    An argument is a folder of sessions, a session, or a data file, which is imported; none means the folder of the
    settings. Raises UsageProblem when there is no session at all.
    """
    found: dict[Path, SessionSummary] = {}
    for argument in arguments or (str(settings.sessions),):
        for source in _sources(argument, settings):
            found.setdefault(source.folder.resolve(), source)
    if not found:
        raise UsageProblem(f"no session in {', '.join(arguments) or settings.sessions}")
    return tuple(found.values())


def is_folder_of_sessions(argument: str) -> bool:
    """Check whether an argument is a folder that holds sessions and is none."""
    folder = Path(argument)
    return folder.is_dir() and not (folder / INFO).exists() and not (folder / RAW).exists()


def is_folder_of_files(argument: str) -> bool:
    """Check whether an argument is a folder that holds files and neither a session nor any of its own."""
    folder = Path(argument)
    if not is_folder_of_sessions(argument) or list_sessions(folder):
        return False
    return any(entry.is_file() and not entry.name.startswith(".") for entry in folder.iterdir())


def default_folder(arguments: tuple[str, ...], settings: Settings) -> Path:
    """Find where a campaign is kept: in the folder of sessions, when there is only one, else in the settings'."""
    if len(arguments) == 1 and is_folder_of_sessions(arguments[0]):
        return Path(arguments[0]) / FOLDER
    return settings.sessions / FOLDER


def _sources(argument: str, settings: Settings) -> tuple[SessionSummary, ...]:
    if is_folder_of_sessions(argument):
        return list_sessions(argument)
    if not Path(argument).exists() and argument == str(settings.sessions):
        return ()
    try:
        session = open_session(argument, settings.sessions)
    except StationError as error:
        if Path(argument).is_dir():
            return (SessionSummary(Path(argument), None, str(error)),)
        raise
    return (SessionSummary(session.folder, session.info),)
