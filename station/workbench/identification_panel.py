"""Both identifications of a session, the lag, and the paper's Tables 1 and 2, also of several releases."""

from nicegui import ui

from station.text.content import Table
from station.workbench import view_models, widgets
from station.workbench.others_menu import OthersMenu
from station.workbench.session_list import SessionList
from station.workbench.session_state import SessionState
from station.workbench.worker import Cancelled, Failed, Job


class IdentificationPanel:
    """Found when it is first looked at, and again when other releases are chosen."""

    def __init__(self, session: SessionState, session_list: SessionList) -> None:
        self._session = session
        self._others = OthersMenu(session, session_list, self.open)
        self._job: Job | None = None
        self._shown: object = None

    def build(self) -> None:
        """Make the panel; it is empty until it is opened."""
        with widgets.line():
            with ui.element("div").classes("grow"):
                widgets.head("Stiffness and damping by two methods")
            self._others.build()
        self._busy = widgets.line()
        self._body = ui.element("div").classes("tables")

    async def open(self) -> None:
        """Show what both methods find."""
        wanted = (self._session.view.stamp[:1] if self._session.view else (), self._session.others)
        if self._job is not None:
            self._job.cancel()
        if wanted == self._shown:
            return
        job = self._job = Job()
        self._busy.clear()
        with self._busy:
            widgets.spinner()
            widgets.label("Identifying: envelope and frequency, and the restoring force surface", "grow")
            widgets.button("Cancel", job.cancel)
        try:
            found = await self._session.ask(job, "identify", self._session.others)
        except Cancelled:
            return
        except Failed as failure:
            self._say(str(failure))
        else:
            self._shown = wanted
            self._show(found)
        finally:
            if self._job is job:
                self._job = None
                self._busy.clear()

    def _say(self, text: str) -> None:
        self._body.clear()
        with self._body, widgets.card("tight"):
            widgets.label(text, "bad wrap")

    def _show(self, found: view_models.Identified) -> None:
        self._body.clear()
        with self._body:
            if found.judgement:
                with widgets.card(f"tight judged {'' if found.quotable else 'not-quotable'}"):
                    widgets.label(found.judgement, f"strong wrap {'good' if found.quotable else 'bad'}")
                    widgets.label(found.beside, "small wrap")
            with widgets.card("tight"):
                widgets.label(f"Lag: {found.lag}", "small wrap")
            for table in found.tables:
                with widgets.card("tight"):
                    text_table(table)
            with widgets.card("tight"):
                for note in found.notes:
                    widgets.label(note, "small wrap")


def text_table(table: Table) -> None:
    """Show a table of words and numbers."""
    with ui.element("div").classes("table-scroll"), ui.element("table").classes("numbers-table"):
        with ui.element("caption"):
            widgets.label(table.caption)
        with ui.element("thead"), ui.element("tr"):
            for name in table.head:
                with ui.element("th").props("scope=col"):
                    widgets.label(name)
        with ui.element("tbody"):
            for row in table.rows:
                with ui.element("tr"):
                    for cell in row:
                        with ui.element("td"):
                            widgets.label(cell)
