"""Validate: the present model predicts releases that it was not fitted to."""

from nicegui import ui

from station.workbench import telling, widgets
from station.workbench.others_menu import others_menu
from station.workbench.session_list import SessionList
from station.workbench.session_state import SessionState
from station.workbench.telling_panel import TellingPanel


def validate_dialog(session: SessionState, session_list: SessionList) -> ui.dialog:
    """Make the dialog, closed: choose releases, and read how well they are predicted."""

    async def validate() -> None:
        if session.others:
            await told.open(session.others)
        else:
            ui.notify("Choose at least one other release.")

    with ui.dialog() as dialog, ui.element("div").classes("card dialog"):
        widgets.label("Validate on another release", "strong")
        widgets.label(
            "The physics of the model stays as it is; only the start, the zero and the lag of the other release are "
            "fitted. A model that is right predicts it better than the usual one.",
            "small wrap",
        )
        with widgets.line():
            others_menu(session, session_list)
            widgets.button("Validate", validate, strong=True)
            widgets.button("Close", dialog.close)
        with ui.element("div").props("aria-live=polite"):
            told = TellingPanel(session, telling.validated, "predicting")
    dialog.on_value_change(lambda e: None if e.value else told.cancel())
    return dialog
