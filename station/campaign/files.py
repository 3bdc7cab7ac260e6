"""A folder of files from one logger: each becomes sessions by one recipe, with what its name and a table say of it."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from daq.errors import StationError
from daq.importing.options import ImportOptions
from daq.importing.propose import Doubtful
from daq.importing.recipe import Recipe, read_recipe
from daq.session import Session
from daq.session_info import SessionInfo
from daq.session_reading import RECIPE
from station.campaign.metadata import Known
from station.exits import UsageProblem
from station.results.sessions import import_file, made_of

NUMBERS = {"d": r"([-+]?\d+)", "f": r"([-+]?\d+(?:[.,]\d+)?)"}
TEXTS = ("specimen", "operator")
METADATA = ("conditions", "varies", "specimen", "operator", "mass_kg", "mass_std_kg")
_FIELD = re.compile(r"\{([^{}:]*)(?::([^{}]*))?\}")


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
