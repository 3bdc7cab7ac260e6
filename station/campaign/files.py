"""A folder of files from one logger: each becomes sessions by one recipe, with what its name and a table say of it."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
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


@dataclass(frozen=True)
class Names:
    """What a file's name says: `{arm:d}P.txt` finds the number 60 in `60P.txt`.

    `:d` is a whole number, `:f` one that may have a point; both become conditions of the test. `{specimen}` and
    `{operator}` are text, `{}` is any. Raises UsageProblem where the pattern is none of this.
    """

    pattern: str
    _form: re.Pattern[str] = field(init=False, repr=False)
    _fields: tuple[tuple[str, str], ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        form, end = "", 0
        fields = []
        for match in _FIELD.finditer(self.pattern):
            name, kind = match[1].strip(), match[2] or ""
            if (kind and (kind not in NUMBERS or not name)) or (not kind and name not in ("", *TEXTS)):
                raise UsageProblem(
                    f"--names {self.pattern}: {match[0]} is no field; write {{NAME:d}} for a whole number, {{NAME:f}} for "
                    "another, {specimen} or {operator} for a text, {} for what is not meant"
                )
            form += re.escape(self.pattern[end : match.start()]) + NUMBERS.get(kind, "(.+?)")
            end = match.end()
            fields.append((name, kind))
        object.__setattr__(self, "_form", re.compile(form + re.escape(self.pattern[end:])))
        object.__setattr__(self, "_fields", tuple(fields))

    def said(self, name: str) -> tuple[dict[str, float], dict[str, str]] | None:
        """Return the numbers and the texts in a file's name, None where it is not of this form."""
        match = self._form.fullmatch(name)
        if match is None:
            return None
        found = list(zip(self._fields, match.groups(), strict=True))
        numbers = {key: float(text.replace(",", ".")) for (key, kind), text in found if kind}
        return numbers, {key: text for (key, kind), text in found if key and not kind}


@dataclass(frozen=True)
class FolderImport:
    """How the files of a folder become sessions: those in `place`, by `recipe`, or each by what is found out of it.

    `known` is what a table says of a file, by its name; `info` is common to all; recipes that were confirmed are looked for
    in `kept`.
    """

    place: Path
    kept: Path
    recipe: Recipe | None
    names: Names | None
    known: Mapping[str, Known]
    info: SessionInfo

    def sessions(self, files: Sequence[Path], say: Callable[[str], None]) -> Iterator[Path]:
        """Yield the folder of each session; a file that cannot be read is one line to `say`.

        What was imported before, by the same recipe and with the same metadata, is not imported again. Raises Doubtful where
        something is to be said of a file first, and nothing of it has been said.
        """
        for file in files:
            told = ({}, {}) if self.names is None else self.names.said(file.name)
            if told is None:
                say(
                    f"{file.name}: its name is not of the form {self.names.pattern if self.names else ''}: left out"
                )
                continue
            conditions = told[0] | self.known.get(file.name, Known()).conditions
            info = self.info.model_copy(update={"conditions": self.info.conditions | conditions, **told[1]})
            try:
                yield from self._before(file, info) or self._imported(file, info)
            except StationError as refusal:
                if isinstance(refusal, Doubtful) and self.recipe is None:
                    raise
                say(f"{file.name}: left out: {str(refusal).removeprefix(f'{file.name}: ')}")

    def _imported(self, file: Path, info: SessionInfo) -> list[Path]:
        made = import_file(file, None, self.place, ImportOptions(), info, self.recipe, kept=self.kept)
        return [session.folder for session in made.sessions]

    def _before(self, file: Path, info: SessionInfo) -> list[Path]:
        """Return the sessions that were made of this very file in the same way."""
        return [folder for folder in made_of(file, self.place) if self._is_same(folder, info)]

    def _is_same(self, folder: Path, info: SessionInfo) -> bool:
        known, recipe = Session.open(folder).info, folder / RECIPE
        same = all(getattr(known, key) == getattr(info, key) for key in METADATA)
        if not same or not recipe.is_file() or self.recipe is None:
            return same and recipe.is_file()
        used = read_recipe(recipe)
        return used == self.recipe.model_copy(update={"confirmed": True, "stated": used.stated})


def files_in(folder: Path, beside: Sequence[Path | None]) -> list[Path]:
    """Return the files of a folder, by name, but for hidden ones and those `beside`: a recipe, a table."""
    known = {path.resolve() for path in beside if path is not None}
    plain = (path for path in folder.iterdir() if path.is_file() and not path.name.startswith("."))
    return sorted(path for path in plain if path.resolve() not in known)
