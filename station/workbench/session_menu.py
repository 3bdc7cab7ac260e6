"""The menu of a session: rename, notes, what is known of the specimen, export, delete."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from nicegui import ui

from daq.errors import StationError
from daq.session import Session
from station.exits import Problem
from station.operations.workers import Failed
from station.workbench import further_tasks, tasks, widgets
from station.workbench.session_list import address_of
from station.workbench.session_state import AppState, SessionState
from station.workbench.stored_sessions import describe, rename, to_bin


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
            describe(folder, **changes, mass_kg=mass.value)
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
        """Show the dialog with what is made inside, and the answers under it; a Problem of what is done stands there."""

        def attempt() -> None:
            try:
                does()
            except Problem as error:
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
            text = await self._session.ask(further_tasks.export)
        except Failed as failure:
            ui.notify(f"Nothing was exported: {failure}")
        else:
            ui.download.content(text, f"{self._key}.csv", "text/csv")

    def _leave(self, place: Path, address: str) -> None:
        """Tell that the session was moved to a place, and go elsewhere."""
        self._state.moved(self._session.folder, place)
        ui.navigate.to(address)
