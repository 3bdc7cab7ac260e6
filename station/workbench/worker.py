"""Workers: processes that compute while the page stays awake; one is cancelled by ending it."""

import asyncio
import contextlib
import multiprocessing
import signal
import threading
import traceback
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from daq.errors import StationError
from daq.session import finish_change
from station import exits
from station.library_messages import say_in_one_line
from station.settings import Settings
from station.story.pipeline import Progress, silent

MOST = 2
STOP_S = 5.0
LOOK_S = 0.1
"""How often a task that waits for a worker looks whether it was cancelled."""


class Cancelled(Exception):
    """The operator cancelled a computation."""


class Failed(Exception):
    """A computation failed; the message is a sentence for the operator, `code` the exit code it would have."""

    def __init__(self, sentence: str, code: int = exits.UNEXPECTED) -> None:
        super().__init__(sentence)
        self.code = code


class Worker:
    """One process that does one task after another; `served` are the keys whose caches it holds."""

    def __init__(self, settings: Settings) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, other = context.Pipe()
        self._process = context.Process(
            target=_serve, args=(other, settings), daemon=True, name="workbench-worker"
        )
        self._process.start()
        other.close()
        self.served: set[str] = set()
        self.busy = False

    @property
    def alive(self) -> bool:
        """Whether the process runs."""
        return self._process.is_alive()

    def do(self, task: str, arguments: tuple[Any, ...], progress: Progress) -> Any:
        """Do a task and return its result; blocks. Raises Failed, or Cancelled when the process was ended."""
        try:
            self._pipe.send((task, arguments))
            while True:
                kind, content = self._pipe.recv()
                if kind == "progress":
                    progress(content)
                elif kind == "done":
                    return content
                else:
                    raise Failed(*content)
        except (EOFError, OSError) as error:
            raise Cancelled from error

    def end(self) -> None:
        """End the process; a task that it is doing raises Cancelled."""
        self._process.terminate()
        self._process.join(STOP_S)
        if self._process.is_alive():
            self._process.kill()
            self._process.join(STOP_S)


def _serve(pipe: Connection, settings: Settings) -> None:
    """Do what comes through the pipe until it is closed; runs in the worker's process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the server, which then ends its workers
    say_in_one_line()
    from station.workbench import tasks

    def progress(text: str) -> None:
        pipe.send(("progress", text))

    try:
        while True:
            name, arguments = pipe.recv()
            try:
                result = tasks.TASKS[name](settings, progress, *arguments)
            except Exception as error:
                pipe.send(("failed", (_sentence(error), exits.code_of(error))))
            else:
                pipe.send(("done", result))
    except (EOFError, OSError):  # the server has gone
        return


def _sentence(error: Exception) -> str:
    text = " ".join(str(error).split()) or type(error).__name__
    if exits.code_of(error) != exits.UNEXPECTED or isinstance(error, exits.Problem):
        return text
    place = traceback.extract_tb(error.__traceback__)[-1]
    what = f"{type(error).__name__}: {text}; {place.name}, line {place.lineno}"
    return f"a fault of this program ({what}); nothing recorded is lost"


def _finish_changes(arguments: tuple[Any, ...]) -> None:
    """Complete what a worker that was ended had begun to write into the session of its task."""
    for folder in arguments:
        if isinstance(folder, Path) and folder.is_dir():
            with contextlib.suppress(StationError):  # told by whoever opens the session next
                finish_change(folder)


@dataclass(eq=False)
class Job:
    """A task under way: `cancel` ends it."""

    worker: Worker | None = None
    cancelled: bool = False
    lock: threading.Lock = field(default_factory=threading.Lock)

    def cancel(self) -> None:
        """End the task; the pool starts another worker."""
        with self.lock:
            self.cancelled = True
            worker = self.worker
        if worker is not None:
            worker.end()


class WorkerPool:
    """A few workers that share the tasks; those of one key go to the one whose cache knows it where it is free."""

    def __init__(self, settings: Settings, most: int = MOST) -> None:
        self._settings = settings
        self._workers = [Worker(settings) for _ in range(most)]
        self._free = asyncio.Condition()
        self._threads = ThreadPoolExecutor(most, thread_name_prefix="workers")

    async def do(self, job: Job, key: str, task: str, *arguments: Any, progress: Progress = silent) -> Any:
        """Do a task when a worker is free; raises Failed or Cancelled."""
        worker = await self._take(job, key)
        try:
            if job.cancelled:
                raise Cancelled
            loop = asyncio.get_running_loop()
            result = await loop.run_in_executor(self._threads, worker.do, task, arguments, progress)
        except Cancelled:
            await asyncio.to_thread(_finish_changes, arguments)
            if job.cancelled:
                raise
            raise Failed(
                "the computation ended unexpectedly (out of memory?); nothing recorded is lost"
            ) from None
        finally:
            await self._give_back(job, worker)
        if job.cancelled:
            raise Cancelled
        return result

    async def warm(self) -> None:
        """Let every worker compile what it will need."""
        for number in range(len(self._workers)):
            try:
                await self.do(Job(), f"warm {number}", "warm")
            except (Cancelled, Failed):
                return

    def end(self) -> None:
        """End all workers."""
        for worker in self._workers:
            worker.end()
        self._threads.shutdown(wait=False, cancel_futures=True)

    async def _take(self, job: Job, key: str) -> Worker:
        async with self._free:
            while not any(not w.busy for w in self._workers):
                if job.cancelled:
                    raise Cancelled
                with contextlib.suppress(TimeoutError):
                    await asyncio.wait_for(self._free.wait(), LOOK_S)
            idle = [w for w in self._workers if not w.busy]
            worker = next((w for w in idle if key in w.served), min(idle, key=lambda w: len(w.served)))
            worker.busy = True
            worker.served.add(key)
            with job.lock:
                job.worker = worker
            return worker

    async def _give_back(self, job: Job, worker: Worker) -> None:
        with job.lock:
            job.worker = None
        async with self._free:
            worker.busy = False
            if job.cancelled or not worker.alive:
                self._workers[self._workers.index(worker)] = Worker(self._settings)
            self._free.notify_all()
