"""The tab 3-D / Rerun: a session's recording in Rerun's own viewer."""

import asyncio

from nicegui import ui

from station.workbench import further_tasks, widgets
from station.workbench.app_state import AppState
from station.workbench.served_files import viewer_address
from station.workbench.session_state import SessionState
from station.workbench.waiting import Waiting
from station.workbench.worker import Failed


class RerunTab:
    """Made when it is first looked at, and again on request: writing a recording takes some seconds."""

    def __init__(self, state: AppState, session: SessionState, key: str, host: str) -> None:
        self._state, self._session, self._key, self._host = state, session, key, host
        self._waiting = Waiting(state.workers)
        self._place = ui.element("div")
        self._made: object = None

    async def open(self, dark: bool) -> None:
        """Show the recording of the session as its results stand."""
        view, folder = self._session.view, self._session.folder
        if view is None or self._waiting.busy or self._made == (view.stamp, dark):
            return
        self._place.clear()
        words, made = "Writing the viewer's recording", (folder, self._state.temporary, dark)
        try:
            stamp = await self._waiting.do(words, str(folder), further_tasks.viewer, *made)
        except (asyncio.CancelledError, Failed) as failure:
            with self._place, widgets.card("tight"), widgets.line():
                widgets.label(str(failure) or "Cancelled.", "grow wrap")
                widgets.button("Try again", lambda: self.open(dark))
            return
        self._made = (view.stamp, dark)
        with self._place:
            with widgets.card("tight viewer-wait"), widgets.line():
                widgets.spinner()
                widgets.label(
                    "Rerun's viewer is starting: its program has 43 MB, which takes up to half a minute the first time.",
                    "grow",
                )
            frame = ui.element("iframe").classes("rerun")
            frame.props["src"] = viewer_address(self._key, stamp, self._host, dark)
            frame.props["title"] = "Rerun viewer"
