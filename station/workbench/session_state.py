"""One session as every tab that shows it sees it. One computation at a time; each change has a number."""

import asyncio
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from station.workbench import view_models
from station.workbench.worker import Cancelled, Failed, Job, WorkerPool


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
        self.force_maps: dict[str, view_models.ForceMap] = {}
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
        from station.workbench.build_view_models import results_stamp

        title = self.running.title if self.running else task
        try:
            found = await self._workers.do(
                job, str(self.folder), task, self.folder, *arguments, progress=self._on_progress
            )
            if isinstance(found, tuple):
                self.view, self.force_maps = found
            else:
                if self.view is not None and found.diagnosis != self.view.diagnosis:
                    self.force_maps = {}  # a command has diagnosed since
                self.view = found
        except Cancelled:
            changed = self.view is not None and self.view.stamp != results_stamp(self.folder)
            self.notice = (
                f"{title}: cancelled; {'its results are kept already' if changed else 'nothing was changed'}"
            )
        except Failed as failure:
            if self.view is None:
                self.problem = str(failure)
            else:
                self.notice = str(failure)
        finally:
            self.running, self._job = None, None
            self.version += 1
        if self.view is not None and self.view.diagnosis is not None and not self.force_maps:
            await self._find_force_maps()

    async def _find_force_maps(self) -> None:
        try:
            self.force_maps = await self._workers.do(Job(), str(self.folder), "force_maps", self.folder)
        except (Cancelled, Failed):
            return
        self.version += 1

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
