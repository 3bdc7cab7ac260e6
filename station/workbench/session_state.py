"""One session as every tab that shows it sees it. One computation at a time; each change has a number."""

import asyncio
import contextlib
import re
import time
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import Event

from station.results.diagnosis_document import DiagnosisDocument
from station.results.ladder import KeptLadder
from station.story.pipeline import Progress, silent
from station.workbench import view_models
from station.workbench.build_view_models import results_stamp
from station.workbench.worker import Cancelled, Failed, Job, WorkerPool

MOST_UNDONE = 50


@dataclass(frozen=True)
class Running:
    """A computation under way: what it is called, since when (monotonic s), and whether it may take long."""

    title: str
    since: float
    long: bool


class SessionState:
    """The state of one session on the page; `version` grows with every change, and `news` tells the tabs at once."""

    def __init__(self, folder: Path, workers: WorkerPool) -> None:
        self.folder = folder
        self.view: view_models.View | None = None
        self.summary = ""
        self._summarised: view_models.View | None = None
        self.frames: dict[str, view_models.Frame] = {}
        self.suspect_frames: dict[str, str] = {}
        self._suspects_drawn = False
        self.earlier: list[KeptLadder] = []
        self._diagnoses: dict[tuple[str, ...], DiagnosisDocument] = {}
        self.others: tuple[Path, ...] = ()
        self.problem = ""
        self.notice = ""
        self.progress = ""
        self.running: Running | None = None
        self.version = 0
        self.news = Event[[]]()
        self.workers = workers
        self._job: Job | None = None
        self._tasks: set[asyncio.Task[None]] = set()

    @property
    def busy(self) -> bool:
        """Whether a computation is under way."""
        return self.running is not None

    def open(self) -> None:
        """Look at the session unless it is known as its results stand."""
        if self.busy or (self.view is not None and self.view.stamp == results_stamp(self.folder)):
            return
        self.start("Reading and fitting", "look")

    def start(self, title: str, task: str, *arguments: Any, long: bool = False) -> bool:
        """Begin a task that returns a view; False while another is under way."""
        if self.busy:
            self.notice = f"{self.running.title if self.running else ''} is under way; wait, or cancel it"
            self.changed()
            return False
        self.running = Running(title, time.monotonic(), long)
        self._loop = asyncio.get_running_loop()
        self.progress, self.problem = "", ""
        self.notice = self.notice if task == "look" else ""
        self._job = Job()
        self.version += 1  # shown in a moment: the task goes first
        running = asyncio.get_running_loop().create_task(self._run(self._job, task, arguments))
        self._tasks.add(running)
        running.add_done_callback(self._tasks.discard)
        return True

    def changed(self) -> None:
        """Tell every tab that there is something to show."""
        self.version += 1
        self.news.emit()

    def cancel(self) -> None:
        """End the computation that is under way; what was kept before stays."""
        if self._job is not None:
            job = self._job
            asyncio.get_running_loop().run_in_executor(None, job.cancel)

    async def _run(self, job: Job, task: str, arguments: tuple[Any, ...]) -> None:
        title = self.running.title if self.running else task
        try:
            found = await self.workers.do(
                job, str(self.folder), task, self.folder, *arguments, progress=self._on_progress
            )
            self._take(task, found)
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
            self.changed()
        await asyncio.gather(self._complete_frames(), self._complete_summary())  # a worker for each
        if task in ("add", "remove") and not job.cancelled:
            self._ask_again()

    def _ask_again(self) -> None:
        """Ask what the new model lacks, where the one before was asked about and this one does not reach the floor."""
        view = self.view
        if view is None or view.diagnosis is None or self.busy or view.about_present or view.at_floor:
            return
        self.start("Asking what the new model lacks", "diagnose", self.others, long=True)

    def _take(self, task: str, found: view_models.View) -> None:
        """Take what a task returned; what the ladder was before is remembered, so that it can be undone."""
        if found.diagnosis is not None:
            self._diagnoses[tuple(found.diagnosis.model.effects)] = found.diagnosis
            known = self._diagnoses.get(tuple(found.ladder.top.effects))
            if known is not None and not found.about_present:
                found = replace(found, diagnosis=known)  # that of the model that one has gone back to
        before, self.view = self.view, found
        self.notice = found.note or self.notice
        if before is not None and _steps(before.ladder) != _steps(found.ladder):
            self.earlier = (
                self.earlier[:-1] if task == "restore" else [*self.earlier, before.ladder][-MOST_UNDONE:]
            )
        if before is None or _steps(before.ladder) != _steps(found.ladder):
            self.summary = ""  # of another model
        if before is not None and found.diagnosis != before.diagnosis:  # by the page or by a command
            self.suspect_frames, self._suspects_drawn = {}, False
        wanted = {*found.step_frames, *self.suspect_frames.values()}
        self.frames = {name: frame for name, frame in self.frames.items() if name in wanted} | found.frames

    async def _complete_summary(self) -> None:
        """Compare the present model with the measurement: that is asked for once the ladder is on the page."""
        view = self.view
        if view is None or view is self._summarised:
            return
        with contextlib.suppress(Cancelled, Failed):
            found = await self.ask(Job(), "summary")
            if view is self.view:
                self.summary, self._summarised = found, view
                self.changed()

    async def _complete_frames(self) -> None:
        """Let the frames be drawn that are not at hand: of other steps, and of the suspects."""
        view = self.view
        if view is None:
            return
        document = view.diagnosis if view.about_present else None
        suspects = document is not None and bool(document.suspects) and not self._suspects_drawn
        if not suspects and all(name in self.frames for name in view.step_frames):
            return
        try:
            found = await self.ask(Job(), "frames", document, progress=partial(self._on_drawn, view))
        except (Cancelled, Failed):
            return
        if self._take_drawn(view, found):
            self._suspects_drawn |= suspects

    def _on_drawn(self, view: view_models.View, content: str | view_models.Drawn) -> None:
        """Show a suspect's frame as soon as it is drawn. Called in the worker's thread."""
        if not isinstance(content, str):
            self._loop.call_soon_threadsafe(self._take_drawn, view, content)

    def _take_drawn(self, view: view_models.View, found: view_models.Drawn) -> bool:
        if view is not self.view:  # another task has answered meanwhile, and asks for its own
            return False
        self.frames, self.suspect_frames = self.frames | found.frames, self.suspect_frames | found.suspects
        self.changed()
        return True

    async def ask(self, job: Job, task: str, *arguments: Any, progress: Progress = silent) -> Any:
        """Do a task beside the ladder, while the ladder stays as it is; raises Failed or Cancelled."""
        return await self.workers.do(job, str(self.folder), task, self.folder, *arguments, progress=progress)

    def undo(self) -> None:
        """Go back to the ladder before the last change."""
        if self.earlier:
            self.start("Undoing", "restore", self.earlier[-1])

    @property
    def share_done(self) -> float | None:
        """How far the step under way is, 0 to 1; None where it does not count what it does."""
        counted = re.search(r"(\d+) of (\d+)", self.progress) if self.busy else None
        if counted is None or int(counted[2]) == 0:
            return None
        return min(1.0, int(counted[1]) / int(counted[2]))

    def _on_progress(self, content: str | view_models.View) -> None:
        """Note what a worker says; a view of what was found so far is shown at once. Called in the worker's thread."""
        if isinstance(content, str):
            self.progress = content
        else:
            self._loop.call_soon_threadsafe(self._take_meanwhile, content)

    def _take_meanwhile(self, found: view_models.View) -> None:
        if self.busy:
            self._take("refine", found)
            self.changed()


def _steps(ladder: KeptLadder) -> object:
    """Pick out what makes two ladders different to the operator."""
    return ladder.present, ladder.steps


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
