"""Left, the sessions: name, date, verdict, amplitude and a sparkline of each; and a place to drop a file."""

import asyncio
import tempfile
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import events, ui

from station.exits import UsageProblem
from station.operations.examples import EXAMPLES
from station.operations.workers import Failed, Task
from station.workbench import further_tasks, widgets
from station.workbench.app_state import AppState
from station.workbench.import_choices import ImportChoices
from station.workbench.import_tasks import import_files
from station.workbench.parts import part
from station.workbench.session_list import Entry, address_of
from station.workbench.stored_sessions import plain_name
from station.workbench.view_models import Imported, ImportQuestion
from station.workbench.waiting import Waiting

LARGEST = 200 << 20
FEW = 4
"""Sessions that are seen at a glance, so that no filter is needed."""


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
            key = await self._do(f"reading {name}", further_tasks.open_example, name)
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
            files.append(Path(self._folder.name) / plain_name(one.name))
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
