"""What a worker does for the page: the running task with its progress and a way to stop it, and results that are told."""

import asyncio
from collections.abc import Callable
from typing import Any

from nicegui import ui

from station.operations.workers import Failed, Task, WorkerPool
from station.text.content import Told
from station.workbench import telling, widgets
from station.workbench.parts import part
from station.workbench.session_state import SessionState


class BusyLine:
    """The line; `cancel` is called to stop what runs."""

    def __init__(self, cancel: Callable[[], object], classes: str = "") -> None:
        with widgets.line(classes).props("role=status aria-live=polite") as self._line:
            widgets.html("contents").content = part("turning", 18)
            self._label = widgets.label("", "small grow wrap")
            self._bar = ui.linear_progress(0.0, show_value=False).props("instant-feedback rounded")
            self._bar.classes("share").set_visibility(False)
            widgets.button("Cancel", cancel)
        self.show("")

    def show(self, words: str, share: float | None = None) -> None:
        """Say what runs and how far it is, 0 to 1; nothing runs without words."""
        self._line.set_visibility(bool(words))
        self._label.text = words
        self._bar.set_visibility(share is not None)
        self._bar.value = round(share or 0.0, 2)


class Waiting:
    """A place of the page in which one task at a time is done."""

    def __init__(self, workers: WorkerPool) -> None:
        self._workers = workers
        self._line = BusyLine(self.cancel)
        self._job: asyncio.Future[Any] | None = None

    @property
    def busy(self) -> bool:
        """Whether a task is under way."""
        return self._job is not None

    async def do(self, words: str, key: str, task: Task, *arguments: Any) -> Any:
        """Do a task and return its result, saying `words`, then what it says of itself. Raises Failed, or CancelledError."""
        self._line.show(words)
        job = self._job = asyncio.ensure_future(self._workers.do(key, task, *arguments, say=self._line.show))
        try:
            return await job
        finally:
            if self._job is job:
                self._job = None
                self._line.show("")

    def cancel(self) -> None:
        """End the task where one is under way."""
        if self._job is not None:
            self._job.cancel()


class TellingPanel(Waiting):
    """What a function of a worker tells of a session, empty until it is opened; `doing` says what it does meanwhile."""

    def __init__(self, session: SessionState, what: Callable[..., Told | str], doing: str) -> None:
        super().__init__(session.workers)
        self._session, self._what, self._doing = session, what, doing
        self._wanted: object = None
        self._body = widgets.html("told")

    def show(self, told: str) -> None:
        """Show what was told before, as HTML."""
        self._body.content = told

    async def open(self, *arguments: object, anew: bool = False) -> None:
        """Show what is told with `arguments`, unless that is shown already of the session as it stands, or under way."""
        view, folder = self._session.view, self._session.folder
        wanted = (None if view is None else view.stamp, arguments)
        if wanted == self._wanted and (self.busy or not anew):
            return
        self.cancel()
        self._wanted, self._body.content = wanted, "" if anew else self._body.content
        try:
            told = (folder, self._what, *arguments)
            self._body.content = await self.do(self._doing, str(folder), telling.tell, *told)
        except (asyncio.CancelledError, Failed) as failure:
            if self._wanted == wanted:
                self._wanted = None
                said = str(failure) or "Cancelled; ask again to see it."
                self._body.content = part("told", Told(said, "bad", ()))
