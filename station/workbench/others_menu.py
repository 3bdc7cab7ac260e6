"""Other releases: which sessions are diagnosed, tabulated or predicted together with the one that is open."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from nicegui import ui

from station.workbench import widgets
from station.workbench.session_list import SessionList
from station.workbench.session_state import SessionState

MOST = 30
FIT = ("OK", "sealed", "recovered")


def others_menu(
    session: SessionState, session_list: SessionList, changed: Callable[[], Any] = lambda: None
) -> None:
    """Show a button with a list of sessions to tick; what is ticked is remembered for the session."""

    def called() -> str:
        count = len(session.others)
        return f"With {count} other{'s' if count > 1 else ''}" if count else "With others"

    def tick(folder: Path, on: bool) -> Any:
        session.others = (*(other for other in session.others if other != folder), *([folder] if on else []))
        return changed()

    def fill() -> None:
        body.clear()
        offered = [e for e in session_list.entries() if e.folder != session.folder and not e.problem][:MOST]
        with body:
            widgets.label(
                "Releases of the same bench and specimen, looked at together:"
                if offered
                else "There is no other session yet.",
                "small faint wrap",
            )
            for entry in offered:
                doubt = "" if entry.verdict in FIT else f" ({entry.verdict})"
                box = ui.checkbox(f"{entry.key}{doubt}", value=entry.folder in session.others)
                box.on_value_change(lambda e, f=entry.folder: tick(f, bool(e.value)))
                box.props("dense").classes("small")

    with widgets.button(called(), lambda: None, "Choose releases to look at together") as button:
        button.bind_text_from(session, "others", lambda _: called())
        with ui.menu().props("max-height=360px") as menu:
            body = ui.element("div").classes("why")
    menu.on_value_change(lambda e: fill() if e.value else None)
