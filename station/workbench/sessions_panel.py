"""Left, the sessions: name, date, verdict, amplitude and a sparkline of each; and a place to drop a file."""

import tempfile
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import quote

from nicegui import events, ui

from station.exits import UsageProblem
from station.operations.examples import EXAMPLES
from station.workbench import widgets
from station.workbench.app_state import AppState
from station.workbench.import_choices import ImportChoices
from station.workbench.session_list import Entry
from station.workbench.stored_sessions import plain_name
from station.workbench.view_models import Campaign, ImportQuestion
from station.workbench.waiting import Waiting
from station.workbench.worker import Cancelled, Failed

LARGEST = 200 << 20
GOOD = ("OK", "sealed")
FEW = 4
"""Sessions that are seen at a glance, so that no filter is needed."""


def address_of(key: str) -> str:
    """Return the address of a session's page."""
    return f"/?session={quote(key, safe='')}"


class SessionsPanel:
    """The list, and what imports a file into it."""

    def __init__(self, state: AppState, chosen: str | None) -> None:
        self._session_list, self._states = state.session_list, state.sessions
        self._waiting = Waiting(state.workers)
        self._chosen = chosen
        self._seen: tuple[Entry, ...] | None = None
        self._seen_refused: set[str] = set()
        self._folder: tempfile.TemporaryDirectory[str] | None = None

    def build(self) -> None:
        """Make the panel."""
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
            self._mass = ui.number("Mass, kg", min=0).props("dense outlined")
            self._waiting.build()
            self._message = ui.element("div").props("aria-live=polite")
        with widgets.card("grow"):
            with widgets.line():
                with ui.element("div").classes("grow"):
                    widgets.head("Sessions")
                self._chosen_text = widgets.label("", "small faint")
            self._filter = ui.input(placeholder="filter", on_change=lambda: self._show())
            self._filter.props('dense outlined clearable aria-label="Filter the sessions"')
            self._filter.set_visibility(False)
            self._list = ui.element("nav").props('aria-label="Sessions"')
            with (
                ui.expansion("Examples")
                .props("dense dense-toggle id=examples")
                .classes("small") as self._expansion
            ):
                for example in EXAMPLES:
                    does = partial(self._open_example, example.name)
                    with widgets.line("small"):
                        widgets.button(
                            example.name, does, f"Open the example {example.name}: {example.about}"
                        )
        self.refresh()
        ui.timer(2.0, self.refresh)
        ui.timer(0.6, self._thumbnails, once=True)

    def refresh(self) -> None:
        """Show the list as the folder is now."""
        entries = self._session_list.entries()
        refused = {entry.key for entry in entries if self._refused(entry.folder)}
        if entries == self._seen and refused == self._seen_refused:
            return
        self._seen_refused = refused
        fresh = self._seen is not None and any(e.thumbnail is None and not e.problem for e in entries)
        self._seen = entries
        self._show()
        if fresh:
            ui.timer(0.1, self._thumbnails, once=True)

    def _show(self) -> None:
        entries = self._seen or ()
        words = str(self._filter.value or "").lower().split()
        shown = [e for e in entries if all(word in e.words for word in words)]
        self._filter.set_visibility(len(entries) > FEW)
        self._chosen_text.text = f"{len(shown)} of {len(entries)}" if words else ""
        self._list.clear()
        with self._list:
            if self._session_list.problem:
                widgets.label(self._session_list.problem, "bad small wrap")
            elif not entries:
                with ui.element("div").classes("empty"):
                    widgets.label("No session yet.")
                    widgets.label("Record a release, drop a file above, or open an example below.", "small")
                self._expansion.value = True
            for entry in shown:
                self._row(entry)

    async def _open_example(self, name: str) -> None:
        if self._waiting.job is not None:
            return
        self._message.clear()
        try:
            key = await self._waiting.do(f"reading {name}", "imports", "example", name)
        except Cancelled:
            self._say(f"opening {name} was cancelled", "faint")
        except Failed as failure:
            self._say(str(failure), "bad")
        else:
            with self._message:  # the button is gone by now: the list shows the session
                ui.navigate.to(address_of(key))

    def _row(self, entry: Entry) -> None:
        link = ui.element("a").classes("session" + (" chosen" if entry.key == self._chosen else ""))
        link.props["href"] = address_of(entry.key)
        if entry.key == self._chosen:
            link.props["aria-current"] = "page"
        with link:
            widgets.label(entry.key, "name").style("grid-column:1/-1").tooltip(str(entry.folder))
            thumbnail = entry.thumbnail
            with widgets.line("small faint"):
                refused = self._refused(entry.folder)
                word = "no analysis" if refused else entry.verdict
                widgets.label(word, f"tag {'ok' if word in GOOD else 'bad'}")
            widgets.sparkline(thumbnail.line if thumbnail else [])
            amplitude = f" · {thumbnail.amplitude}" if thumbnail and thumbnail.amplitude else ""
            widgets.label(f"{entry.date}{amplitude}", "small faint date")
            problem = entry.problem or (thumbnail.problem if thumbnail else "")
            if problem:
                widgets.label(problem, "small bad wrap").style("grid-column:1/-1")

    def _refused(self, folder: Path) -> bool:
        known = self._states.known.get(folder)
        return known is not None and bool(known.problem)

    async def _thumbnails(self) -> None:
        if await self._session_list.make_thumbnails():
            self.refresh()

    async def _dropped(self, given: events.MultiUploadEventArguments) -> None:
        self._upload.reset()
        if self._waiting.job is not None:
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
        self._message.clear()
        first, mass = files[0], self._mass.value or None
        words = f"reading {first.name if len(files) == 1 else f'{len(files)} files'}"
        recipe = choices.answered() if choices is not None else None
        ask = recipe is None and (bool(self._ask.value) or len(files) > 1)
        task: tuple[Any, ...] = ("import", first, recipe, ask, mass)
        if choices is not None and len(files) > 1:
            task = ("files", files, recipe, *choices.of_files(), mass)
        told: ImportQuestion | Campaign | tuple[list[str], list[str]]
        try:
            told = await self._waiting.do(words, "imports", *task)
        except Cancelled:
            self._say(f"the import of {first.name} was cancelled", "faint")
        except (Failed, OSError) as failure:
            self._say(str(failure).replace(f"{first.parent}/", ""), "bad")
        else:
            with self._message:
                if isinstance(told, ImportQuestion):
                    self._question(files, told)
                elif isinstance(told, Campaign):
                    self._together(told)
                elif recipe is not None:  # it was looked at: the session opens
                    ui.navigate.to(address_of(told[0][0]))
                else:
                    self._made(first.name, *told)

    def _question(self, files: list[Path], question: ImportQuestion) -> None:
        with ui.dialog(value=True) as dialog, ui.element("div").classes("card dialog"):
            choices = ImportChoices(question, files)
            with widgets.line():
                does = partial(self._answered, files, choices, dialog)
                what = files[0].name if len(files) == 1 else f"{len(files)} files"
                widgets.button("Looks right", does, f"Read {what} so", strong=True)
                widgets.button("Cancel", dialog.close)

    async def _answered(self, files: list[Path], choices: ImportChoices, dialog: ui.dialog) -> None:
        try:
            choices.answered()
        except UsageProblem as problem:
            ui.notify(str(problem), type="negative")
        else:
            dialog.close()
            await self._import(files, choices)

    def _together(self, told: Campaign) -> None:
        """Show what a campaign says of several files."""
        self.refresh()
        with ui.dialog(value=True) as dialog, ui.element("div").classes("card dialog"):
            widgets.head(f"{len(told.sessions)} sessions together")
            widgets.label(told.text, "small").style("white-space:pre; font-family:monospace; overflow-x:auto")
            with widgets.line():
                does = partial(ui.navigate.to, address_of(told.sessions[0]))
                widgets.button(f"Open {told.sessions[0]}", does, strong=True)
                widgets.button("Close", dialog.close)

    def _made(self, name: str, made: list[str], notes: list[str]) -> None:
        """Open the first session that was made, with a notice of the others and of what was guessed."""
        first, *others = made
        place = self._session_list.folder_of(first)
        if place is not None:
            said = [*notes, *([f"its other releases: {', '.join(others)}"] if others else [])]
            self._states.at(place).notice = f"{name} was imported: {'; '.join(said)}"
        ui.navigate.to(address_of(first))

    def _say(self, text: str, kind: str) -> None:
        self._message.clear()
        with self._message:
            widgets.label(text, f"small wrap {kind}")
