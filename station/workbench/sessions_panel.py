"""Left, the sessions: name, date, verdict, amplitude and a sparkline of each; and a place to drop a file."""

import asyncio
import tempfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import events, ui
from pydantic import ValidationError

from daq.importing.recipe import ROLES, Recipe
from station.exits import UsageProblem
from station.operations.examples import EXAMPLES
from station.operations.workers import Failed, Task
from station.results.sessions import safe_name
from station.workbench import widgets
from station.workbench.import_tasks import Imported, ImportQuestion, import_files, open_example
from station.workbench.parts import part
from station.workbench.session_list import Entry, address_of
from station.workbench.session_state import AppState
from station.workbench.waiting import Waiting

LARGEST = 200 << 20
FEW = 4
"""Sessions that are seen at a glance, so that no filter is needed."""
UNITS = ("s", "ms", "us", "m", "mm", "um", "rad", "deg", "m/s", "deg/s", "m/s^2", "g", "N", "V", "counts")
"""The units that are offered; any other that is known may be typed."""


class ImportChoices:
    """The question about a file, which stands for all `files`; `answered` gives the recipe, `of_files` what else."""

    def __init__(self, question: ImportQuestion, files: Sequence[Path]) -> None:
        self._recipe = question.recipe
        self._boxes: list[tuple[ui.select, ui.select]] = []
        widgets.label(question.sentence, "small wrap")
        with ui.element("div").classes("asked"):
            for head in ("column", "first rows", "", "what it is", "in"):
                widgets.label(head, "small faint")
            for column, field in zip(question.columns, question.recipe.fields, strict=True):
                run = f", run {field.run}" if field.run else ""
                widgets.label(f"{column.place}{run}", "small strong wrap")
                widgets.label(column.numbers, "small faint wrap")
                widgets.html().content = part("sparkline", column.line)
                role = _select(f"Role of {column.place}", list(ROLES), field.role)
                units = list(dict.fromkeys(("", field.unit, *UNITS)))
                known = field.unit != "counts" or field.name  # of a column without a head it is a guess
                unit = _select(f"Unit of {column.place}", units, field.unit if known else "")
                unit.props("use-input hide-selected fill-input new-value-mode=add-unique")
                self._boxes.append((role, unit))
        rate = "Rate, Hz (in place of time stamps)"
        self._rate = widgets.number(rate, question.recipe.rate).props("clearable")
        self._of_files: list[ui.input] = []
        if len(files) > 1:
            widgets.label(
                f"The other {len(files) - 1} files are read alike, and all are looked at together.",
                "small wrap",
            )
            for said in (
                "Numbers in the names of files: {arm:d}P.txt takes 12 from 12P.txt as arm",
                "What varies between them, as stiffness,inertia",
            ):
                self._of_files.append(ui.input(said).props("dense outlined"))

    def of_files(self) -> tuple[str, ...]:
        """Return the form of the names of files, and what varies between them, as they are typed; nothing for one file."""
        return tuple(str(box.value or "") for box in self._of_files)

    def answered(self) -> Recipe:
        """Return the recipe as the boxes stand. Raises UsageProblem, in a sentence, where a unit does not fit a role."""
        said: dict[str, Any] = self._recipe.model_dump(by_alias=True)
        for field, (role, unit) in zip(said["fields"], self._boxes, strict=True):
            if field["unit"] and not unit.value and role.value not in ("ignored", "run"):
                raise UsageProblem(f"choose the unit of the {role.value}")
            field |= {"role": role.value, "unit": unit.value or ""}
        try:
            return Recipe.model_validate(said | {"rate": self._rate.value or None})
        except ValidationError as error:
            first = error.errors(include_url=False, include_input=False)[0]
            raise UsageProblem(first["msg"].removeprefix("Value error, ")) from None


def _select(name: str, options: list[str], value: str) -> ui.select:
    made = ui.select(options, value=value).props("dense outlined options-dense").classes("grow")
    made.props["aria-label"] = name
    return made


class SessionsPanel:
    """The list, and what imports a file into it."""

    def __init__(self, state: AppState, chosen: str | None) -> None:
        self._state, self._chosen = state, chosen
        self._entries: tuple[Entry, ...] = ()
        self._shown: object = None
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        with widgets.card():
            widgets.head("Import a recording")
            with ui.element("div").classes("drop"):
                self._upload = ui.upload(
                    label="Drop a file here, or several of one logger: CSV, MATLAB .mat, UFF58",
                    multiple=True,
                    auto_upload=True,
                    max_file_size=LARGEST,
                    on_multi_upload=self._dropped,
                    on_rejected=lambda: self._say("that file is too large: at most 200 MB", "bad"),
                ).props('aria-label="Import a recording"')
            self._ask = ui.checkbox("Show the columns first").props("dense").classes("small")
            self._mass = widgets.number("Mass, kg")
            self._waiting = Waiting(state.workers)
            self._message = widgets.html().props("aria-live=polite")
        with widgets.card("grow"):
            with widgets.line():
                widgets.head("Sessions")
                self._count = widgets.label("", "small faint")
            self._filter = ui.input(placeholder="filter", on_change=lambda: self._show())
            self._filter.props('dense outlined clearable aria-label="Filter the sessions"')
            self._list = widgets.html().props('role=navigation aria-label="Sessions"')
            with ui.expansion("Examples").props("dense dense-toggle id=examples") as self._examples:
                for example in EXAMPLES:
                    does = partial(self._open_example, example.name)
                    widgets.button(example.name, does, f"Open the example {example.name}: {example.about}")
            self._examples.classes("small")
        ui.timer(2.0, self._refresh)

    async def _refresh(self) -> None:
        self._entries = await asyncio.to_thread(self._state.session_list.entries, thumbnails=True)
        self._show()

    def _show(self) -> None:
        """Show the list as the folder is now."""
        entries, words = self._entries, str(self._filter.value or "").lower().split()
        refused = {folder for folder, known in self._state.sessions.items() if known.problem}
        if (entries, words, refused) == self._shown:
            return
        self._shown = entries, words, refused
        shown = [e for e in entries if all(word in e.words for word in words)]
        self._filter.set_visibility(len(entries) > FEW)
        self._count.text = f"{len(shown)} of {len(entries)}" if words else ""
        if entries:
            self._list.content = part("sessions", shown, self._chosen, refused)
        else:
            first = "Record a release, drop a file above, or open an example below."
            said = [("No session yet.", "faint"), (first, "small faint")]
            problem = self._state.session_list.problem
            self._list.content = part("lines", [(problem, "bad small")] if problem else said)
            self._examples.value = True

    async def _do(self, words: str, task: Task, *arguments: Any) -> Any:
        """Do a task and return what it found; None where it found nothing, and the reason is said."""
        self._say("")
        try:
            return await self._waiting.do(words, "imports", task, *arguments)
        except asyncio.CancelledError:
            self._say(f"{words} was cancelled", "faint")
        except Failed as failure:
            self._say(str(failure).replace(f"{self._folder.name}/" if self._folder else "\0", ""), "bad")

    async def _open_example(self, name: str) -> None:
        if not self._waiting.busy:
            key = await self._do(f"reading {name}", open_example, name)
            if key is not None:
                with self._message:  # the button may be gone by now
                    ui.navigate.to(address_of(key))

    async def _dropped(self, given: events.MultiUploadEventArguments) -> None:
        self._upload.reset()
        if self._waiting.busy:
            self._say("another import is under way; cancel it, or wait", "bad")
            return
        self._folder = tempfile.TemporaryDirectory(prefix="workbench-")  # one before goes with its files
        files = []
        for one in given.files:
            files.append(Path(self._folder.name) / safe_name(one.name))
            await one.save(files[-1])
        await self._import(sorted(files))

    async def _import(self, files: list[Path], choices: ImportChoices | None = None) -> None:
        """Make sessions of files, or show what is to be said of the first before."""
        answers = () if choices is None else (choices.answered(), *choices.of_files())
        words, mass = f"reading {_called(files)}", self._mass.value or None
        found = await self._do(words, import_files, files, mass, bool(self._ask.value), *answers)
        with self._message:
            if isinstance(found, ImportQuestion):
                self._question(files, found)
            elif found is not None and len(files) > 1:
                self._together(found)
            elif found is not None:
                self._made(files[0].name, found)

    def _question(self, files: list[Path], question: ImportQuestion) -> None:
        async def answered() -> None:
            try:
                choices.answered()
            except UsageProblem as problem:
                ui.notify(str(problem), type="negative")
            else:
                dialog.close()
                await self._import(files, choices)

        with ui.dialog(value=True) as dialog, ui.element("div").classes("card dialog"):
            choices = ImportChoices(question, files)
            with widgets.line():
                widgets.button("Looks right", answered, f"Read {_called(files)} so", strong=True)
                widgets.button("Cancel", dialog.close)

    def _together(self, found: Imported) -> None:
        """Show what a campaign says of several files."""
        first = found.sessions[0]
        with ui.dialog(value=True) as dialog, ui.element("div").classes("card dialog"):
            widgets.head(f"{len(found.sessions)} sessions together")
            widgets.html("told").content = found.told
            with widgets.line():
                widgets.button(f"Open {first}", partial(ui.navigate.to, address_of(first)), strong=True)
                widgets.button("Close", dialog.close)

    def _made(self, name: str, found: Imported) -> None:
        """Open the first session that was made, with a notice of the others and of what was guessed."""
        first = found.sessions[0]
        place = self._state.session_list.folder_of(first)
        if place is not None:
            self._state.session(place).notice = f"{name} was imported: {found.told}"
        ui.navigate.to(address_of(first))

    def _say(self, text: str, kind: str = "") -> None:
        self._message.content = part("lines", [(text, f"small {kind}")])


def _called(files: list[Path]) -> str:
    return files[0].name if len(files) == 1 else f"{len(files)} files"
