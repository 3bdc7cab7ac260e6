"""The menu of a session: rename, notes, what is known of the specimen, share, export, delete."""

import json
from collections.abc import Callable

from nicegui import ui

from daq.session import Session
from station.exits import Problem
from station.workbench import widgets
from station.workbench.app_state import AppState
from station.workbench.session_state import SessionState
from station.workbench.sessions_panel import address_of
from station.workbench.stored_sessions import describe, rename, to_bin
from station.workbench.worker import Cancelled, Failed, Job


class SessionMenu:
    """A button with a menu, and the dialogs behind it."""

    def __init__(self, state: AppState, session: SessionState, key: str) -> None:
        self._state, self._session, self._key = state, session, key

    def build(self) -> None:
        """Make the button."""
        made = widgets.button("Session", lambda: None, "What can be done with this session")
        with made, ui.menu():
            ui.menu_item("Name, notes, specimen …", self._edit)
            ui.menu_item("Share: copy the address", self._share)
            ui.menu_item("Export samples as CSV", self._export)
            ui.menu_item("Begin the ladder again", lambda: self._session.start("Beginning again", "again"))
            ui.menu_item("Delete …", self._delete)
        with ui.dialog() as self._dialog, ui.element("div").classes("card dialog"):
            self._body = ui.element("div").classes("dialog-body")

    def _edit(self) -> None:
        try:
            info = Session.open(self._session.folder).info
        except Exception as error:  # a damaged session can still be deleted
            ui.notify(f"This session cannot be read: {error}")
            return
        self._body.clear()
        with self._body:
            widgets.label("Name, notes and specimen", "strong")
            name = ui.input("Name", value=self._key).props("dense outlined autocomplete=off")
            specimen = ui.input("Specimen", value=info.specimen).props("dense outlined autocomplete=off")
            operator = ui.input("Operator", value=info.operator).props("dense outlined autocomplete=off")
            mass = ui.number("Mass, kg", value=info.mass_kg, min=0, format="%g").props("dense outlined")
            notes = ui.textarea("Notes", value=info.remarks).props("dense outlined autogrow")

        def save() -> None:
            describe(
                self._session.folder,
                specimen=specimen.value or "",
                operator=operator.value or "",
                remarks=notes.value or "",
                mass_kg=mass.value,
            )
            place = rename(self._session.folder, str(name.value or ""))
            if place != self._session.folder:
                self._leave(address_of(place.name))
                return
            self._dialog.close()
            self._session.start("Reading and fitting", "look")

        self._ask(save, "Save", "Cancel")

    async def _share(self) -> None:
        address = await ui.run_javascript("bench.address()", timeout=5.0)
        copied = await ui.run_javascript(f"bench.copy({json.dumps(address)})", timeout=5.0)
        ui.notify(f"{'Copied' if copied else 'The address'}: {address}", multi_line=True, timeout=8000)

    async def _export(self) -> None:
        try:
            text = await self._session.ask(Job(), "export")
        except (Failed, Cancelled) as failure:
            ui.notify(f"Nothing was exported: {failure}")
            return
        ui.download.content(text, f"{self._key}.csv", "text/csv")

    def _delete(self) -> None:
        self._body.clear()
        with self._body:
            widgets.label(f"Delete {self._key}?", "strong wrap")
            widgets.label(
                "It is moved to the folder .bin beside the sessions, from which it can be taken back.",
                "small wrap",
            )

        def delete() -> None:
            to_bin(self._session.folder)
            self._leave("/")

        self._ask(delete, "Move to the bin", "Keep it")

    def _ask(self, does: Callable[[], None], yes: str, no: str) -> None:
        """Put the answers under what the dialog says; a Problem of what is done stands there."""

        def attempt() -> None:
            try:
                does()
            except Problem as error:
                problem.text = str(error)

        with self._body:
            problem = widgets.label("", "bad small wrap").props("aria-live=polite")
            with widgets.line():
                widgets.button(yes, attempt, strong=True)
                widgets.button(no, self._dialog.close)
        self._dialog.open()

    def _leave(self, address: str) -> None:
        """Forget the session as it was, and go elsewhere."""
        self._state.sessions.known.pop(self._session.folder, None)
        ui.navigate.to(address)
