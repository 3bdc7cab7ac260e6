"""The menu of a session: rename, notes, what is known of the specimen, export; delete moves it into the bin."""

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from nicegui import ui

from daq.errors import StationError
from daq.session import Session
from daq.storage import Lock
from station.exits import Problem, UsageProblem
from station.operations.workers import Failed
from station.results.sessions import safe_name
from station.workbench import tasks, widgets
from station.workbench.session_list import address_of
from station.workbench.session_state import AppState, SessionState


def rename(folder: Path, wanted: str) -> Path:
    """Give a session and its folder another name; UsageProblem where that is none, or is taken."""
    name = safe_name(wanted) if wanted.strip() else ""
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


def to_bin(folder: Path) -> Path:
    """Move a session into the bin beside it, from which it can be taken back by hand; return where it is now."""
    place = folder.parent / ".bin" / f"{folder.name}_{time.strftime('%Y%m%d_%H%M%S')}"
    place.parent.mkdir(exist_ok=True)
    _move(folder, place)
    return place


def _move(folder: Path, place: Path) -> None:
    with Lock(folder):  # nobody writes it
        pass
    try:
        os.rename(folder, place)
    except OSError as error:
        raise UsageProblem(f"{folder.name} was not moved: {error.strerror or error}") from error


class SessionMenu:
    """A button with a menu, and the dialog behind it."""

    def __init__(self, state: AppState, session: SessionState, key: str) -> None:
        self._state, self._session, self._key = state, session, key
        with (
            widgets.button("Session", lambda: None, "What can be done with this session"),
            ui.menu(),
        ):
            ui.menu_item("Name, notes, specimen …", self._edit)
            ui.menu_item("Export samples as CSV", self._export)
            ui.menu_item(
                "Begin the ladder again", lambda: session.start("Beginning again", tasks.begin_again)
            )
            ui.menu_item("Delete …", self._delete)
        with ui.dialog() as self._dialog:
            self._body = ui.element("div").classes("card dialog")

    def _edit(self) -> None:
        folder = self._session.folder
        try:
            info = Session.open(folder).info
        except StationError as error:  # a damaged session can still be deleted
            ui.notify(f"This session cannot be read: {error}")
            return

        def save() -> None:
            changes = {name: field.value or "" for name, field in texts.items()}
            Session.open(folder).update(**changes, mass_kg=mass.value or None)
            place = rename(folder, str(name.value or ""))
            if place != folder:
                self._leave(place, address_of(place.name))
                return
            self._dialog.close()
            self._session.start("Reading and fitting", tasks.look)

        with self._asking("Name, notes and specimen", save, "Save", "Cancel"):
            name = ui.input("Name", value=self._key)
            texts = {
                "specimen": ui.input("Specimen", value=info.specimen),
                "operator": ui.input("Operator", value=info.operator),
                "remarks": ui.textarea("Notes", value=info.remarks).props("autogrow"),
            }
            mass = widgets.number("Mass, kg", info.mass_kg)
            for field in (name, *texts.values()):
                field.props("dense outlined autocomplete=off")

    def _delete(self) -> None:
        def delete() -> None:
            to_bin(self._session.folder)
            self._leave(self._session.folder, "/")

        with self._asking(f"Delete {self._key}?", delete, "Move to the bin", "Keep it"):
            widgets.label(
                "It is moved to the folder .bin beside the sessions, from which it can be taken back.",
                "small wrap",
            )

    @contextmanager
    def _asking(self, title: str, does: Callable[[], None], yes: str, no: str) -> Iterator[None]:
        """Show the dialog with what is made inside, and the answers under it; what could not be done is said there."""

        def attempt() -> None:
            try:
                does()
            except (Problem, StationError) as error:
                problem.text = str(error)

        self._body.clear()
        with self._body:
            widgets.label(title, "strong wrap")
            yield
            problem = widgets.label("", "bad small wrap").props("aria-live=polite")
            with widgets.line():
                widgets.button(yes, attempt, strong=True)
                widgets.button(no, self._dialog.close)
        self._dialog.open()

    async def _export(self) -> None:
        try:
            text = await self._session.ask(tasks.export)
        except Failed as failure:
            ui.notify(f"Nothing was exported: {failure}")
        else:
            ui.download.content(text, f"{self._key}.csv", "text/csv")

    def _leave(self, place: Path, address: str) -> None:
        """Tell that the session was moved to a place, and go elsewhere."""
        self._session.cancel()
        self._state.moved(self._session.folder, place)
        ui.navigate.to(address)
