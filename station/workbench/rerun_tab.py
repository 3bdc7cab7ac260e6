"""The tab 3-D / Rerun: a session's recording in Rerun's own viewer."""

from collections.abc import Callable

from nicegui import ui

from station.workbench import widgets
from station.workbench.app_state import AppState
from station.workbench.session_state import SessionState
from station.workbench.viewer_files import address_of
from station.workbench.waiting import Waiting
from station.workbench.worker import Cancelled, Failed


class RerunTab:
    """Made when it is first looked at, and again on request: writing a recording takes some seconds."""

    def __init__(
        self, state: AppState, session: SessionState, key: str, host: str, dark: Callable[[], bool]
    ) -> None:
        self._state, self._session, self._key, self._host, self._dark = state, session, key, host, dark
        self._waiting = Waiting(state.workers)
        self._made: object = None

    def build(self) -> None:
        """Make the tab; it is empty until it is opened."""
        self._waiting.build()
        self._top = ui.element("div")
        self._frame = ui.element("div")

    async def open(self) -> None:
        """Show the recording of the session as its results stand."""
        view = self._session.view
        if view is None or self._waiting.job is not None or self._made == (view.stamp, self._dark()):
            return
        self._frame.clear()
        self._top.clear()
        folder, made = self._session.folder, (self._state.temporary, self._dark())
        try:
            stamp = await self._waiting.do(
                "Writing the viewer's recording", str(folder), "viewer", folder, *made
            )
        except Cancelled:
            self._say("Cancelled.")
        except Failed as failure:
            self._say(str(failure))
        else:
            self._made = (view.stamp, self._dark())
            with self._frame:
                with widgets.card("tight viewer-wait"), widgets.line():
                    widgets.spinner()
                    widgets.label(
                        "Rerun's viewer is starting: its program has 43 MB, which takes up to half a minute the first time.",
                        "grow",
                    )
                frame = ui.element("iframe").classes("rerun")
                frame.props["src"] = address_of(self._key, stamp, self._host, dark=self._dark())
                frame.props["title"] = "Rerun viewer"

    def _say(self, text: str) -> None:
        self._top.clear()
        with self._top, widgets.card("tight"), widgets.line():
            widgets.label(text, "grow wrap")
            widgets.button("Try again", self.open)
