"""The sessions of a campaign: those in a folder, those that were named, or those made of files of one logger."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from daq.errors import StationError
from daq.importing.options import ImportOptions
from daq.importing.propose import Doubtful
from daq.importing.recipe import Recipe, read_recipe
from daq.session import Session, SessionSummary, list_sessions
from daq.session_info import SessionInfo
from daq.session_reading import INFO, RAW, RECIPE
from station.campaign.metadata import Known
from station.exits import UsageProblem
from station.results.sessions import import_file, made_of, open_session
from station.settings import Settings

FOLDER = "campaign"
NUMBERS = {"d": r"([-+]?\d+)", "f": r"([-+]?\d+(?:[.,]\d+)?)"}
TEXTS = ("specimen", "operator")
METADATA = ("conditions", "varies", "specimen", "operator", "mass_kg", "mass_std_kg")
_FIELD = re.compile(r"\{([^{}:]*)(?::([^{}]*))?\}")


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


class Names:
    """A pattern of file names: `{arm:d}P.txt` finds the number 60 in `60P.txt`.

    `:d` is a whole number, `:f` one that may have a point; both become conditions of the test. `{specimen}` and
    `{operator}` are text, `{}` is any. Raises UsageProblem where the pattern is none of this.
    """

    def __init__(self, pattern: str) -> None:
        self.pattern = pattern
        self._fields: list[tuple[str, str]] = []
        form, end = "", 0
        for match in _FIELD.finditer(pattern):
            name, kind = match[1].strip(), match[2] or ""
            if (kind and (kind not in NUMBERS or not name)) or (not kind and name not in ("", *TEXTS)):
                raise UsageProblem(
                    f"--names {pattern}: {match[0]} is no field; write {{NAME:d}} for a whole number, {{NAME:f}} for "
                    "another, {specimen} or {operator} for a text, {} for a part to ignore"
                )
            form += re.escape(pattern[end : match.start()]) + NUMBERS.get(kind, "(.+?)")
            end = match.end()
            self._fields.append((name, kind))
        self._form = re.compile(form + re.escape(pattern[end:]))

    def said(self, name: str) -> tuple[dict[str, float], dict[str, str]] | None:
        """Return the numbers and the texts in a file's name, None where it is not of this form."""
        match = self._form.fullmatch(name)
        if match is None:
            return None
        found = list(zip(self._fields, match.groups(), strict=True))
        numbers = {key: float(text.replace(",", ".")) for (key, kind), text in found if kind}
        return numbers, {key: text for (key, kind), text in found if key and not kind}


def import_files(
    files: Sequence[Path],
    place: Path,
    recipe: Recipe | None,
    names: Names | None,
    known: Mapping[str, Known],
    info: SessionInfo,
    say: Callable[[str], None],
    kept: Path | None = None,
) -> Iterator[Path]:
    """Make sessions of files in `place`, by a recipe or each by what is found out of it; yield the folder of each.

    `known` is what a table says of a file, by its name; `info` is common to all; recipes that were confirmed are looked for
    in `kept` (default: `place`). A file that cannot be read is one line to `say`. What was imported before, by the same
    recipe and with the same metadata, is not imported again. Raises Doubtful where something is to be said of a file first,
    and nothing of it has been said.
    """
    for file in files:
        told = ({}, {}) if names is None else names.said(file.name)
        if told is None:
            say(f"{file.name}: its name is not of the form {names.pattern if names else ''}: left out")
            continue
        conditions = info.conditions | told[0] | known.get(file.name, Known()).conditions
        own = info.model_copy(update={"conditions": conditions, **told[1]})
        try:
            before = [folder for folder in made_of(file, place) if _is_same(folder, own, recipe)]
            yield from before or [
                session.folder
                for session in import_file(
                    file, None, place, ImportOptions(), own, recipe, kept=kept
                ).sessions
            ]
        except StationError as refusal:
            if isinstance(refusal, Doubtful) and recipe is None:
                raise
            say(f"{file.name}: left out: {str(refusal).removeprefix(f'{file.name}: ')}")


def _is_same(folder: Path, info: SessionInfo, recipe: Recipe | None) -> bool:
    """Say whether a session was made by this recipe and with this metadata."""
    known, used = Session.open(folder).info, folder / RECIPE
    if not used.is_file() or any(getattr(known, key) != getattr(info, key) for key in METADATA):
        return False
    if recipe is None:
        return True
    read = read_recipe(used)
    return read == recipe.model_copy(update={"confirmed": True, "stated": read.stated})


def files_in(folder: Path, beside: Sequence[Path | None]) -> list[Path]:
    """Return the files of a folder, by name, but for hidden ones and those `beside`: a recipe, a table."""
    known = {path.resolve() for path in beside if path is not None}
    plain = (path for path in folder.iterdir() if path.is_file() and not path.name.startswith("."))
    return sorted(path for path in plain if path.resolve() not in known)
