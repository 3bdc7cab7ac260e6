"""The tab 3-D / Rerun: a session's recording in Rerun's own viewer."""

from collections.abc import Callable

from nicegui import ui

from station.workbench import widgets
from station.workbench.app_state import AppState
from station.workbench.session_state import SessionState
from station.workbench.viewer_files import address_of
from station.workbench.worker import Cancelled, Failed, Job


class RerunTab:
    """Made when it is first looked at, and again on request: writing a recording takes some seconds."""

    def __init__(
        self, state: AppState, session: SessionState, key: str, host: str, dark: Callable[[], bool]
    ) -> None:
        self._state, self._session, self._key, self._host, self._dark = state, session, key, host, dark
        self._job: Job | None = None
        self._made: object = None

    def build(self) -> None:
        """Make the tab; it is empty until it is opened."""
        self._top = ui.element("div")
        self._frame = ui.element("div")

    async def open(self) -> None:
        """Show the recording of the session as its results stand."""
        view = self._session.view
        if view is None or self._job is not None or self._made == (view.stamp, self._dark()):
            return
        self._job = Job()
        self._frame.clear()
        self._top.clear()
        with self._top, widgets.card("tight"), widgets.line():
            widgets.spinner()
            widgets.label("Writing the viewer's recording", "grow")
            widgets.button("Cancel", lambda: self._job.cancel() if self._job else None)
        try:
            stamp = await self._state.workers.do(
                self._job,
                str(self._session.folder),
                "viewer",
                self._session.folder,
                self._state.temporary,
                self._dark(),
            )
        except Cancelled:
            self._say("Cancelled.")
        except Failed as failure:
            self._say(str(failure))
        else:
            self._made = (view.stamp, self._dark())
            self._top.clear()
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
        finally:
            self._job = None

    def _say(self, text: str) -> None:
        self._top.clear()
        with self._top, widgets.card("tight"), widgets.line():
            widgets.label(text, "grow wrap")
            widgets.button("Try again", self.open)
