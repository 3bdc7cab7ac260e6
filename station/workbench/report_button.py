"""The report: one button writes the page that `station report` writes, and opens it in a tab of its own."""

from urllib.parse import quote

from fastapi import FastAPI
from nicegui import ui
from starlette.responses import FileResponse, PlainTextResponse, Response

from station.report.write import NAME
from station.workbench import widgets
from station.workbench.session_list import SessionList
from station.workbench.session_state import SessionState
from station.workbench.waiting import Waiting
from station.workbench.worker import Cancelled, Failed

PLACE = "/report"
POLICY = "sandbox allow-modals; default-src 'none'; style-src 'unsafe-inline'; img-src data:; font-src data:"
"""A report runs no script and belongs to no origin, whoever wrote the file."""


class ReportButton:
    """Report, then the way to it; while it is written, how to cancel."""

    def __init__(self, session: SessionState, key: str) -> None:
        self._session, self._key = session, key
        self._waiting = Waiting(session.workers)

    def build(self) -> None:
        """Make the button."""
        self._waiting.build()
        self._place = widgets.line().props("aria-live=polite")
        widgets.button("Report", self.write, "Write the report of this session")

    async def write(self) -> None:
        """Write the report, and offer it."""
        if self._waiting.job is not None:
            return
        self._place.clear()
        folder = self._session.folder
        try:
            await self._waiting.do("gathering", str(folder), "report", folder)
        except Cancelled:
            return
        except Failed as failure:
            with self._place:
                widgets.label(str(failure), "small bad wrap")
        else:
            with self._place:
                link = ui.link("Open the report", f"{PLACE}/{quote(self._key, safe='')}", new_tab=True)
                link.classes("small strong").style("color: var(--accent)")


def serve_reports(app: FastAPI, session_list: SessionList) -> None:
    """Let the application give the reports of the sessions on offer."""

    @app.get(f"{PLACE}/{{key}}")
    def report(key: str) -> Response:
        session = session_list.folder_of(key)
        file = None if session is None else session / "results" / NAME
        if file is None or not file.is_file() or file.is_symlink():
            return PlainTextResponse("there is no report of this session yet\n", 404)
        return FileResponse(file, media_type="text/html", headers={"Content-Security-Policy": POLICY})
