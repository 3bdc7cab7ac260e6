"""Validate: the present model predicts releases that it was not fitted to."""

from nicegui import ui

from station.workbench import widgets
from station.workbench.others_menu import OthersMenu
from station.workbench.session_list import SessionList
from station.workbench.session_state import SessionState
from station.workbench.telling_panel import TellingPanel


class ValidateDialog:
    """Choose releases, and read how well they are predicted."""

    def __init__(self, session: SessionState, session_list: SessionList) -> None:
        self._session = session
        self._others = OthersMenu(session, session_list)
        self._told = TellingPanel(session, "validated", "predicting")

    def build(self) -> None:
        """Make the dialog, closed."""
        with ui.dialog() as self._dialog, ui.element("div").classes("card dialog"):
            widgets.label("Validate on another release", "strong")
            widgets.label(
                "The physics of the model stays as it is; only the start, the zero and the lag of the other release are "
                "fitted. A model that is right predicts it better than the usual one.",
                "small wrap",
            )
            with widgets.line():
                self._others.build()
                widgets.button("Validate", self._validate, strong=True)
                widgets.button("Close", self._close)
            with ui.element("div").props("aria-live=polite"):
                self._told.build()

    def open(self) -> None:
        """Show the dialog."""
        self._dialog.open()

    def _close(self) -> None:
        self._told.cancel()
        self._dialog.close()

    async def _validate(self) -> None:
        if self._session.others:
            await self._told.open(self._session.others)
        else:
            ui.notify("Choose at least one other release.")
