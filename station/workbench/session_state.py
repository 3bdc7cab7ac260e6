"""One session as every tab that shows it sees it. One computation at a time; each change has a number."""

import asyncio
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from station.results.ladder import KeptLadder
from station.story.pipeline import Progress, silent
from station.workbench import view_models
from station.workbench.worker import Cancelled, Failed, Job, WorkerPool

MOST_UNDONE = 50


@dataclass(frozen=True)
class Running:
    """A computation under way: what it is called, since when (monotonic s), and whether it may take long."""

    title: str
    since: float
    long: bool


class SessionState:
    """The state of one session on the page; `version` grows with every change."""

    def __init__(self, folder: Path, workers: WorkerPool) -> None:
        self.folder = folder
        self.view: view_models.View | None = None
        self.frames: dict[str, view_models.Frame] = {}
        self.suspect_frames: dict[str, str] = {}
        self.earlier: list[KeptLadder] = []
        self.others: tuple[Path, ...] = ()
        self.problem = ""
        self.notice = ""
        self.progress = ""
        self.running: Running | None = None
        self.version = 0
        self._workers = workers
        self._job: Job | None = None
        self._tasks: set[asyncio.Task[None]] = set()

    @property
    def busy(self) -> bool:
        """Whether a computation is under way."""
        return self.running is not None

    def open(self) -> None:
        """Look at the session unless it is known as its results stand."""
        from station.workbench.build_view_models import results_stamp

        if self.busy or (self.view is not None and self.view.stamp == results_stamp(self.folder)):
            return
        self.start("Reading and fitting", "look")

    def start(self, title: str, task: str, *arguments: Any, long: bool = False) -> bool:
        """Begin a task that returns a view; False while another is under way."""
        if self.busy:
            self.notice = f"{self.running.title if self.running else ''} is under way; wait, or cancel it"
            self.version += 1
            return False
        self.running = Running(title, time.monotonic(), long)
        self.progress, self.notice, self.problem = "", "", ""
        self._job = Job()
        self.version += 1
        running = asyncio.get_running_loop().create_task(self._run(self._job, task, arguments))
        self._tasks.add(running)
        running.add_done_callback(self._tasks.discard)
        return True

    def cancel(self) -> None:
        """End the computation that is under way; what was kept before stays."""
        if self._job is not None:
            job = self._job
            asyncio.get_running_loop().run_in_executor(None, job.cancel)

    async def _run(self, job: Job, task: str, arguments: tuple[Any, ...]) -> None:
        title = self.running.title if self.running else task
        try:
            found = await self._workers.do(
                job, str(self.folder), task, self.folder, *arguments, progress=self._on_progress
            )
            self._take(task, found)
        except Cancelled:
            self.notice = f"{title}: cancelled; nothing was changed"
        except Failed as failure:
            if self.view is None:
                self.problem = str(failure)
            else:
                self.notice = str(failure)
        finally:
            self.running, self._job = None, None
            self.version += 1
        await self._complete_frames()

    def _take(self, task: str, found: view_models.View) -> None:
        """Take what a task returned; what the ladder was before is remembered, so that it can be undone."""
        before, self.view = self.view, found
        self.notice = found.note
        if before is not None and before.ladder != found.ladder:
            self.earlier = (
                self.earlier[:-1] if task == "restore" else [*self.earlier, before.ladder][-MOST_UNDONE:]
            )
        if before is not None and found.diagnosis != before.diagnosis:
            self.suspect_frames = {}  # this diagnosis, or one by a command, has other suspects
        wanted = {*found.rung_frames, *self.suspect_frames.values()}
        self.frames = {name: frame for name, frame in self.frames.items() if name in wanted} | found.frames

    async def _complete_frames(self) -> None:
        """Let the frames be drawn that are not at hand: of other rungs, and of the suspects."""
        view = self.view
        if view is None:
            return
        suspects = view.diagnosis is not None and bool(view.diagnosis.suspects) and not self.suspect_frames
        if not suspects and all(name in self.frames for name in view.rung_frames):
            return
        try:
            frames, named = await self._workers.do(Job(), str(self.folder), "frames", self.folder)
        except (Cancelled, Failed):
            return
        if view is not self.view:  # another task has answered meanwhile, and asks for its own
            return
        self.frames, self.suspect_frames = self.frames | frames, named
        self.version += 1

    async def ask(self, job: Job, task: str, *arguments: Any, progress: Progress = silent) -> Any:
        """Return what a task beside the ladder finds, while the ladder stays as it is; raises Failed or Cancelled."""
        return await self._workers.do(job, str(self.folder), task, self.folder, *arguments, progress=progress)

    def undo(self) -> None:
        """Go back to the ladder before the last change."""
        if self.earlier:
            self.start("Undoing", "restore", self.earlier[-1])

    def _on_progress(self, text: str) -> None:
        self.progress = text


@dataclass
class SessionStates:
    """The states of all sessions that are open, by folder."""

    workers: WorkerPool
    known: dict[Path, SessionState] = field(default_factory=dict)

    def at(self, folder: Path) -> SessionState:
        """Return the state of the session in a folder."""
        if folder not in self.known:
            self.known[folder] = SessionState(folder, self.workers)
        return self.known[folder]
