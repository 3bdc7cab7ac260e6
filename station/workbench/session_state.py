"""What all tabs share: each session with one computation at a time, the workers, the list, and the capture under way."""

import asyncio
import contextlib
import re
import time
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from nicegui import Event

from station.operations import refining
from station.operations.workers import Failed, Say, Task, WorkerPool
from station.results.diagnosis_document import DiagnosisDocument
from station.results.ladder import KeptLadder
from station.settings import Settings
from station.story.pipeline import silent
from station.text.layout import sentence
from station.workbench import tasks
from station.workbench.capture_run import CaptureRun
from station.workbench.opened_session import session_stamp
from station.workbench.session_list import SessionList
from station.workbench.statements import called
from station.workbench.view_models import Drawing, Drawn, View


class SessionState:
    """The state of one session on the page; `version` grows with every change, and `news` tells the tabs at once.

    `running` is what the computation under way is called, "" for none, and `since` when it began (monotonic s).
    """

    def __init__(self, folder: Path, workers: WorkerPool) -> None:
        self.folder, self.workers = folder, workers
        self.view: View | None = None
        self.frames: dict[str, Drawing] = {}
        self.suspects = Drawn()
        self.earlier: list[KeptLadder] = []
        self._others: tuple[Path, ...] = ()
        self._diagnoses: dict[tuple[object, ...], DiagnosisDocument] = {}
        self.problem = self.notice = self.progress = self.running = ""
        self.since = 0.0
        self.version = 0
        self.news = Event[[]]()
        self._job: asyncio.Future[View] | None = None
        self._runs: set[asyncio.Task[None]] = set()

    @property
    def others(self) -> tuple[Path, ...]:
        """The other sessions that are looked at together with this one, as far as they are still there."""
        return tuple(folder for folder in self._others if folder.is_dir())

    @others.setter
    def others(self, folders: tuple[Path, ...]) -> None:
        self._others = folders

    def follow(self, folder: Path, place: Path) -> None:
        """Go on with another session that was moved to a place."""
        self._others = tuple(place if other == folder else other for other in self._others)

    def open(self) -> None:
        """Look at the session unless it is known as its results stand."""
        if not self.running and (self.view is None or self.view.stamp != session_stamp(self.folder)):
            self.start("Reading and fitting", tasks.look)

    def start(self, title: str, task: Task, *arguments: Any) -> bool:
        """Begin a task that returns a view; False while another is under way."""
        if self.running:
            self.say(f"{self.running} is under way; wait, or cancel it")
            return False
        self.running, self.since = title, time.monotonic()
        self.progress = self.problem = ""
        self.notice = self.notice if task is tasks.look else ""
        self.version += 1  # shown in a moment: the task goes first
        run = asyncio.get_running_loop().create_task(self._run(title, task, arguments))
        self._runs.add(run)
        run.add_done_callback(self._runs.discard)
        return True

    def change(self, title: str, does: Task, *wanted: Any) -> None:
        """Change the ladder by a function of `station.operations.refining`."""
        self.start(title, tasks.change, does, *wanted)

    def add(self, wanted: str) -> None:
        """Add an effect, an expression of the user's own, or the measured curve."""
        self.change(f"Adding {called(wanted)}", refining.add, wanted)

    def diagnose(self, title: str = "Trying every effect") -> None:
        """Ask what the present model lacks."""
        self.start(title, tasks.diagnose, self.others)

    def say(self, notice: str) -> None:
        """Show a notice in every tab; "" closes the one that is shown."""
        self.notice = notice
        self.changed()

    def changed(self) -> None:
        """Tell every tab that there is something to show."""
        self.version += 1
        self.news.emit()

    def cancel(self) -> None:
        """End the computation that is under way; what was kept before stays."""
        if self._job is not None:
            self._job.cancel()

    async def _run(self, title: str, task: Task, arguments: tuple[Any, ...]) -> None:
        done = False
        try:
            self._job = asyncio.ensure_future(self.ask(task, *arguments, say=self._hear))
            self._take(await self._job, undone=tasks.restore in arguments)
            done = True
        except asyncio.CancelledError:
            changed = self.view is not None and self.view.stamp != session_stamp(self.folder)
            kept = "its results are kept already" if changed else "nothing was changed"
            self.notice = f"{title}: cancelled; {kept}"
        except Failed as failure:
            if self.view is None:
                self.problem = str(failure)
            else:
                self.notice = str(failure)
        finally:
            self.running, self._job = "", None
            self.changed()
        if task is not tasks.look:
            self.open()  # a task that was cancelled, or a command, may have kept something
        await self._complete()
        if done and arguments[:1] in ((refining.add,), (refining.remove,)):
            self._ask_again()

    def _ask_again(self) -> None:
        """Ask what the new model lacks, where the one before was asked about and this one does not reach the floor."""
        view = self.view
        if view is None or view.diagnosis is None or self.running or view.about_present or view.at_floor:
            return
        self.diagnose("Asking what the new model lacks")

    def _hear(self, said: str | View | Drawn) -> None:
        """Note what a worker says; what was found so far is shown at once."""
        if isinstance(said, str) and self.running:
            self.progress = said
            return
        if isinstance(said, str):  # what it finds cannot be kept
            self.notice = sentence(said.removeprefix("note: "))
        elif isinstance(said, View):
            self._take(said)
        else:
            known, self.frames = self.suspects, self.frames | said.frames
            self.suspects = Drawn({}, known.suspects | said.suspects, known.says | said.says)
        self.changed()

    def _take(self, found: View, undone: bool = False) -> None:
        """Take what a task returned; what the ladder was before is remembered, so that it can be undone."""
        recorded = found.stamp[:2]  # of another recording, or with another mass, they are others
        if found.diagnosis is not None:
            self._diagnoses[recorded, *found.diagnosis.model.effects] = found.diagnosis
        known = self._diagnoses.get((recorded, *found.ladder.top.effects), found.diagnosis)
        before, self.view = self.view, (found := replace(found, diagnosis=known))
        self.notice = found.note or self.notice
        if before is not None and _steps(before.ladder) != _steps(found.ladder):
            self.earlier = self.earlier[:-1] if undone else [*self.earlier, before.ladder]
        if before is not None and found.diagnosis != before.diagnosis:  # by the page or by a command
            self.suspects = Drawn()
        wanted = {*found.step_frames, *self.suspects.suspects.values()}
        self.frames = {name: frame for name, frame in self.frames.items() if name in wanted} | found.frames

    async def _complete(self) -> None:
        """Let be made what a view goes without at first: where the model fails, other steps' frames, the suspects."""
        view = self.view
        if view is None:
            return

        suspects = view.diagnosis.suspects if view.diagnosis is not None and view.about_present else []

        def hear(said: Drawn | str) -> None:
            if view is self.view:  # else another task has answered meanwhile, and asks for its own
                self._hear(said)

        with contextlib.suppress(asyncio.CancelledError, Failed):
            await self.ask(tasks.complete, suspects, say=hear)

    async def ask(self, task: Task, *arguments: Any, say: Say = silent) -> Any:
        """Do a task on this session; raises Failed."""
        try:
            return await self.workers.do(str(self.folder), task, self.folder, *arguments, say=say)
        except Failed:
            if self.folder.is_dir():
                raise
            raise Failed(
                f"the folder {self.folder} is gone: it was renamed or removed outside this page"
            ) from None

    def undo(self) -> None:
        """Go back to the ladder before the last change."""
        if self.view is not None and self.earlier:
            self.change("Undoing", tasks.restore, self.earlier[-1].with_(seen=self.view.ladder.seen))

    @property
    def share_done(self) -> float | None:
        """How far the step under way is, 0 to 1; None where it does not count what it does."""
        counted = re.search(r"(\d+) of (\d+)", self.progress) if self.running else None
        if counted is None or int(counted[2]) == 0:
            return None
        return min(1.0, int(counted[1]) / int(counted[2]))


def _steps(ladder: KeptLadder) -> object:
    """Pick out what makes two ladders different to the operator."""
    return ladder.present, ladder.steps


@dataclass
class AppState:
    """Settings, workers, the sessions on offer, those that are open by their folder, and the one capture at a time.

    `temporary` is a folder that goes when the server ends.
    """

    settings: Settings
    workers: WorkerPool
    session_list: SessionList
    temporary: Path
    sessions: dict[Path, SessionState] = field(default_factory=dict)
    capturing: CaptureRun | None = None

    def session(self, folder: Path) -> SessionState:
        """Open the session in a folder, unless a tab has opened it."""
        return self.sessions.setdefault(folder, SessionState(folder, self.workers))

    def moved(self, folder: Path, place: Path) -> None:
        """Forget a session as it was before it was moved; those that are looked at together with it follow it."""
        self.sessions.pop(folder, None)
        for session in self.sessions.values():
            session.follow(folder, place)
