"""The middle of the page without a result: a welcome, a wait, or why a record allows no analysis."""

from collections.abc import Callable

from nicegui import background_tasks, ui

from station.workbench import telling, widgets
from station.workbench.parts import part
from station.workbench.session_state import SessionState
from station.workbench.waiting import TellingPanel


class EmptyMiddle:
    """Seen while there is nothing to show of a session, or no session."""

    def __init__(
        self, session: SessionState | None, key: str | None, solve_mystery: Callable[[], None]
    ) -> None:
        self._session, self._key = session, key
        does = {"solve": lambda _: solve_mystery(), "examples": lambda _: widgets.run("bench.toExamples()")}
        with ui.element("div").classes("empty grow") as self.place:
            self._words = widgets.html("contents", does)
            if session is not None:
                self._recorded = TellingPanel(session, telling.recorded, "Drawing what was recorded")

    def show(self, visible: bool) -> None:
        """Say how it stands, where the middle is empty."""
        self.place.set_visibility(visible)
        problem = "" if self._session is None else self._session.problem
        self._words.content = part("empty", self._key, self._session is not None, problem)
        if problem and visible:
            background_tasks.create(self._draw())

    async def _draw(self) -> None:
        with self.place:
            await self._recorded.open(await widgets.is_dark())
