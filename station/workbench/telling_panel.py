"""A result that a worker tells: asked for when it is first looked at, and again when what it rests on has changed."""

from nicegui import ui

from station.text.content import Equation, Facts, Figure, Paragraph, Part, Table, Told
from station.workbench import widgets
from station.workbench.session_state import SessionState
from station.workbench.waiting import Waiting
from station.workbench.worker import Cancelled, Failed


class TellingPanel:
    """What one task tells of a session; `doing` says what it does meanwhile."""

    def __init__(self, session: SessionState, task: str, doing: str) -> None:
        self._session, self._task, self._doing = session, task, doing
        self._waiting = Waiting(session.workers)
        self._wanted: object = None

    def build(self) -> None:
        """Make the panel; it is empty until it is opened."""
        self._waiting.build()
        self._body = ui.element("div").classes("told")

    async def open(self, *arguments: object) -> None:
        """Show what the task tells with its `arguments`, unless that is shown already of the session as it stands."""
        view = self._session.view
        wanted = (None if view is None else view.stamp, arguments)
        if wanted == self._wanted:
            return
        self.cancel()
        self._wanted = wanted
        try:
            folder = self._session.folder
            self._show(await self._waiting.do(self._doing, str(folder), self._task, folder, *arguments))
        except (Cancelled, Failed) as failure:
            if self._wanted == wanted:
                self._wanted = None
                self._show(Told(str(failure), "bad", ()))

    def cancel(self) -> None:
        """End the task where it is under way."""
        self._waiting.cancel()

    def _show(self, told: Told) -> None:
        self._body.clear()
        with self._body:
            if told.headline:
                with widgets.card(f"tight judged {told.tone}"):
                    widgets.label(told.headline, f"strong wrap {told.tone}")
            for part in told.brief:
                with widgets.card("tight"):
                    _part(part)


def _part(part: Part) -> None:
    match part:
        case Facts():
            with ui.element("dl").classes("facts"):
                for name, text in part.rows:
                    for tag, words in (("dt", name), ("dd", text)):
                        with ui.element(tag):
                            widgets.label(words)
        case Paragraph():
            widgets.label(f"{part.label}: {part.text}" if part.label else part.text, "small wrap")
        case Equation():
            for line in part.lines:
                widgets.label(line, "mono wrap")
        case Table():
            _table(part)
        case Figure():
            drawn = ui.element("img").classes("picture")
            drawn.props["src"], drawn.props["alt"] = part.picture.uri, part.caption
            widgets.label(part.caption, "small faint wrap")


def _table(table: Table) -> None:
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
