"""Other releases: diagnosed, tabulated or predicted together with the session that is open."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from nicegui import ui

from station.workbench import telling, widgets
from station.workbench.parts import part
from station.workbench.session_list import SessionList
from station.workbench.session_state import SessionState
from station.workbench.waiting import TellingPanel


def others_menu(
    session: SessionState, session_list: SessionList, changed: Callable[[], Any] = lambda: None
) -> None:
    """Show a button with a list of sessions to tick; what is ticked is remembered for the session."""

    def called() -> str:
        count = len(session.others)
        return f"With {count} other{'s' if count > 1 else ''}" if count else "With others"

    def tick(folder: str) -> Any:
        rest = tuple(other for other in session.others if other != Path(folder))
        session.others = rest if len(rest) < len(session.others) else (*rest, Path(folder))
        return changed()

    def fill() -> None:
        offered = [e for e in session_list.entries() if e.folder != session.folder and not e.problem]
        body.content = part("others", offered, session.others)

    with widgets.button(called(), lambda: None, "Choose releases to look at together") as button:
        button.bind_text_from(session, "others", lambda _: called())
        with ui.menu().props("max-height=360px") as menu:
            body = widgets.html("why", {"tick": tick})
    menu.on_value_change(lambda e: fill() if e.value else None)


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
            "The physics of the model is held, spring and viscous damping near their values; start, zero, lag, gain and "
            "offsets of the other release are refitted. A model that is right predicts it better than the usual one.",
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
