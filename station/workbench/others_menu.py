"""Other releases: which sessions are diagnosed, tabulated or predicted together with the one that is open."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from nicegui import ui

from station.workbench import widgets
from station.workbench.parts import part
from station.workbench.session_list import SessionList
from station.workbench.session_state import SessionState

MOST = 30


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
        body.content = part("others", offered[:MOST], session.others)

    with widgets.button(called(), lambda: None, "Choose releases to look at together") as button:
        button.bind_text_from(session, "others", lambda _: called())
        with ui.menu().props("max-height=360px") as menu:
            body = widgets.html("why", {"tick": tick})
    menu.on_value_change(lambda e: fill() if e.value else None)
