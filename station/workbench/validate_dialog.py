"""Validate: the present model predicts releases that it was not fitted to."""

from nicegui import ui

from station.workbench import widgets
from station.workbench.identification_panel import text_table
from station.workbench.others_menu import OthersMenu
from station.workbench.session_list import SessionList
from station.workbench.session_state import SessionState
from station.workbench.worker import Cancelled, Failed, Job


class ValidateDialog:
    """Choose releases, and read how well they are predicted."""

    def __init__(self, session: SessionState, session_list: SessionList) -> None:
        self._session = session
        self._others = OthersMenu(session, session_list)
        self._job: Job | None = None

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
                self._go = widgets.button("Validate", self._validate, strong=True)
                widgets.button("Close", self._close)
            self._body = ui.element("div").props("aria-live=polite")

    def open(self) -> None:
        """Show the dialog."""
        self._body.clear()
        self._dialog.open()

    def _close(self) -> None:
        if self._job is not None:
            self._job.cancel()
        self._dialog.close()

    async def _validate(self) -> None:
        if self._job is not None:
            return
        if not self._session.others:
            self._say("Choose at least one other release.")
            return
        self._job = Job()
        self._body.clear()
        with self._body, widgets.line():
            widgets.spinner()
            widgets.label("predicting", "small grow")
        try:
            sentence, table = await self._session.ask(self._job, "validate", self._session.others)
        except Cancelled:
            self._say("Cancelled.")
        except Failed as failure:
            self._say(str(failure))
        else:
            self._body.clear()
            with self._body:
                widgets.label(sentence, "strong wrap")
                text_table(table)
        finally:
            self._job = None

    def _say(self, text: str) -> None:
        self._body.clear()
        with self._body:
            widgets.label(text, "small wrap")
