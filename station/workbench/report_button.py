"""The report: one button writes the page that `station report` writes, and opens it in a tab of its own."""

from urllib.parse import quote

from fastapi import FastAPI
from nicegui import ui
from starlette.responses import FileResponse, PlainTextResponse, Response

from station.report.write import NAME
from station.workbench import widgets
from station.workbench.app_state import AppState
from station.workbench.session_list import SessionList
from station.workbench.session_state import SessionState
from station.workbench.worker import Cancelled, Failed, Job

PLACE = "/report"
POLICY = "sandbox allow-modals; default-src 'none'; style-src 'unsafe-inline'; img-src data:; font-src data:"
"""A report runs no script and belongs to no origin, whoever wrote the file."""


class ReportButton:
    """Report, then the way to it; while it is written, how to cancel."""

    def __init__(self, state: AppState, session: SessionState, key: str) -> None:
        self._state, self._session, self._key = state, session, key
        self._job: Job | None = None
        self._message = ""

    def build(self) -> None:
        """Make the button."""
        self._place = widgets.line().props("aria-live=polite")
        self._offer()
        ui.timer(0.3, self._tick)

    def _offer(self, message: str = "", bad: bool = False) -> None:
        self._place.clear()
        with self._place:
            if message and bad:
                widgets.label(message, "small bad wrap")
            elif message:
                link = ui.link(message, f"{PLACE}/{quote(self._key, safe='')}", new_tab=True).classes(
                    "small strong"
                )
                link.style("color: var(--accent)")
            widgets.button("Report", self.write, "Write the report of this session")

    async def write(self) -> None:
        """Write the report, and offer it."""
        if self._job is not None:
            return
        self._job, self._message = Job(), "gathering"
        self._place.clear()
        with self._place:
            widgets.spinner(16)
            self._words = widgets.label(self._message, "small faint")
            widgets.button("Cancel", self._cancel, "Cancel the report")
        try:
            await self._state.workers.do(
                self._job,
                str(self._session.folder),
                "report",
                self._session.folder,
                progress=self._on_progress,
            )
        except Cancelled:
            self._offer()
        except Failed as failure:
            self._offer(str(failure), bad=True)
        else:
            self._offer("Open the report")
        finally:
            self._job = None

    def _cancel(self) -> None:
        if self._job is not None:
            self._job.cancel()

    def _on_progress(self, text: str) -> None:
        self._message = text

    def _tick(self) -> None:
        if self._job is not None:
            self._words.text = self._message


def serve_reports(app: FastAPI, session_list: SessionList) -> None:
    """Let the application give the reports of the sessions on offer."""

    @app.get(f"{PLACE}/{{key}}")
    def report(key: str) -> Response:
        session = session_list.folder_of(key)
        file = None if session is None else session / "results" / NAME
        if file is None or not file.is_file() or file.is_symlink():
            return PlainTextResponse("there is no report of this session yet\n", 404)
        return FileResponse(file, media_type="text/html", headers={"Content-Security-Policy": POLICY})
