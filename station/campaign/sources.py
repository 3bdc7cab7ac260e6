"""The sessions of a campaign: those in a folder, or those that were named."""

from dataclasses import dataclass
from pathlib import Path

from daq.errors import StationError
from daq.session import Session, list_sessions
from daq.session_info import SessionInfo, State
from daq.session_reading import INFO, RAW
from daq.storage import read_regular
from station.campaign.keys import key_of
from station.campaign.work import Work
from station.exits import UsageProblem
from station.results.sessions import open_session
from station.settings import Settings
from station.story.preparation import options_for

LARGEST = 1 << 30
FOLDER = "campaign"


@dataclass(frozen=True)
class Source:
    """One session: its folder, and its metadata or the problem because of which there are none."""

    folder: Path
    info: SessionInfo | None
    problem: str = ""

    @property
    def name(self) -> str:
        """The name of the session."""
        return self.folder.name

    def work(self, settings: Settings, gain_percent: float | None, diagnose: bool) -> Work:
        """Read the session's files; StationError when they cannot be read, or are still written."""
        session = Session.open(self.folder)
        if session.info.state is State.RECORDING:
            raise StationError("it is being recorded, or was cut off: wait, or seal it by `station recover`")
        raw = read_regular(self.folder / RAW, LARGEST)
        options = options_for(session, settings)
        key = key_of(raw, session.info, options, gain_percent=gain_percent, diagnose=diagnose)
        # The metadata go as they were checked here.
        files = {RAW: raw, INFO: session.info.model_dump_json().encode()}
        return Work(key, self.name, files, options, gain_percent, diagnose)


def find_sources(arguments: tuple[str, ...], settings: Settings) -> tuple[Source, ...]:
    """Return the sessions that are meant, each once, oldest first in a folder.

    An argument is a folder of sessions, a session, or a data file, which is imported; none means the folder of the
    settings. Raises UsageProblem when there is no session at all.
    """
    found: dict[Path, Source] = {}
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


def _sources(argument: str, settings: Settings) -> list[Source]:
    if is_folder_of_sessions(argument):
        return [Source(s.folder, s.info, s.problem or "") for s in list_sessions(argument)]
    if not Path(argument).exists() and argument == str(settings.sessions):
        return []
    try:
        session = open_session(argument, settings.sessions)
    except StationError as error:
        if Path(argument).is_dir():
            return [Source(Path(argument), None, str(error))]
        raise
    return [Source(session.folder, session.info)]
