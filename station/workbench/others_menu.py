"""Other releases: which sessions are diagnosed, tabulated or predicted together with the one that is open."""

from collections.abc import Callable
from pathlib import Path

from nicegui import ui

from station.workbench import widgets
from station.workbench.session_list import SessionList
from station.workbench.session_state import SessionState

MOST = 30
FIT = ("OK", "sealed", "recovered")


class OthersMenu:
    """A button with a list of sessions to tick; what is ticked is remembered for the session."""

    def __init__(
        self, session: SessionState, session_list: SessionList, changed: Callable[[], object] = lambda: None
    ) -> None:
        self._session, self._list, self._changed = session, session_list, changed

    def build(self) -> None:
        """Make the button."""
        self._button = widgets.button("With others", lambda: None, "Choose releases to look at together")
        with self._button, ui.menu().props("max-height=360px") as menu:
            self._body = ui.element("div").classes("why")
        menu.on_value_change(lambda e: self._fill() if e.value else None)
        self._name()

    def _fill(self) -> None:
        self._body.clear()
        with self._body:
            offered = [e for e in self._list.entries() if e.folder != self._session.folder and not e.problem][
                :MOST
            ]
            if not offered:
                widgets.label("There is no other session yet.", "small")
            else:
                widgets.label(
                    "Releases of the same bench and specimen, looked at together:", "small faint wrap"
                )
            for entry in offered:
                ui.checkbox(
                    f"{entry.key}" + ("" if entry.verdict in FIT else f" ({entry.verdict})"),
                    value=entry.folder in self._session.others,
                    on_change=lambda e, f=entry.folder: self._tick(f, bool(e.value)),
                ).props("dense").classes("small")

    def _tick(self, folder: Path, on: bool) -> None:
        rest = tuple(other for other in self._session.others if other != folder)
        self._session.others = (*rest, folder) if on else rest
        self._name()
        self._changed()

    def _name(self) -> None:
        count = len(self._session.others)
        self._button.text = f"With {count} other{'s' if count > 1 else ''}" if count else "With others"
