"""Both identifications of a session, the lag, and the paper's Tables 1 and 2, also of several releases."""

from nicegui import ui

from station.workbench import widgets
from station.workbench.others_menu import OthersMenu
from station.workbench.session_list import SessionList
from station.workbench.session_state import SessionState
from station.workbench.telling_panel import TellingPanel


class IdentificationPanel:
    """Found when it is first looked at, and again when other releases are chosen."""

    def __init__(self, session: SessionState, session_list: SessionList) -> None:
        self._session = session
        self._others = OthersMenu(session, session_list, self.open)
        doing = "Identifying: envelope and frequency, and the restoring force surface"
        self._told = TellingPanel(session, "identified", doing)

    def build(self) -> None:
        """Make the panel; it is empty until it is opened."""
        with widgets.line():
            with ui.element("div").classes("grow"):
                widgets.head("Stiffness and damping by two methods")
            self._others.build()
        self._told.build()

    async def open(self) -> None:
        """Show what both methods find."""
        await self._told.open(self._session.others)
