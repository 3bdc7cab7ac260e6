"""Workers: processes that compute for a page that stays awake. Cancelling a task ends its process."""

import asyncio
import contextlib
import multiprocessing
import os
import re
import signal
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from daq.errors import StationError
from daq.session import finish_change
from station.exits import sentence_of
from station.output import say_in_one_line
from station.settings import Settings
from station.story.pipeline import silent

MOST = 2
LOST = "the computation ended unexpectedly (out of memory?); nothing recorded is lost"
Say = Callable[[Any], None]
"""Called with what a task does, in words, or with a part of what it finds."""

Task = Callable[..., Any]
"""A function of a module, called with the settings, a `Say`, and arguments."""


class Failed(Exception):
    """A computation failed; the message is a sentence for the operator."""


class Ended(Failed):
    """The process ended before its task did, as one that is killed."""


class Worker:
    """One process that does one task after another; `served` are the keys whose caches it holds."""

    def __init__(self, settings: Settings) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, other = context.Pipe()
        self._process = context.Process(
            target=_serve, args=(other, settings), daemon=True, name="station-worker"
        )
        self._process.start()
        other.close()
        self.served: set[str] = set()
        self.busy = False

    def do(self, task: Task, arguments: tuple[Any, ...], say: Say) -> Any:
        """Do a task and return its result; blocks. Raises Failed, or Ended."""
        try:
            self._pipe.send((task, arguments))
            while True:
                kind, content = self._pipe.recv()
                if kind == "said":
                    say(content)
                elif kind == "done":
                    return content
                else:
                    raise Failed(content)
        except (EOFError, OSError) as error:
            raise Ended(LOST) from error

    def end(self) -> None:
        """End the process; a task that it is doing raises Ended."""
        self._process.kill()
        self._process.join()


def _serve(pipe: Connection, settings: Settings) -> None:
    """Do what comes through the pipe until it is closed; runs in the worker's process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the program, which then ends its workers
    threading.Thread(target=_end_with_parent, daemon=True).start()
    say_in_one_line()
    try:
        while True:
            task, arguments = pipe.recv()
            try:
                result = task(settings, lambda content: pipe.send(("said", content)), *arguments)
            except Exception as error:
                pipe.send(("failed", sentence_of(error)))
            else:
                pipe.send(("done", result))
    except (EOFError, OSError):  # the program has gone
        return


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _finish_changes(arguments: tuple[Any, ...]) -> None:
    """Complete what a worker that was ended had begun to write into the session of its task."""
    for folder in arguments:
        if isinstance(folder, Path) and folder.is_dir():
            with contextlib.suppress(StationError):  # told by whoever opens the session next
                finish_change(folder)


OPTION = re.compile(
    r"""see\ `[^`]+`,\ or\                                             # another command
    |\ \([^()]*--[a-z][^()]*\)                                      # what an option does, in brackets
    |,?(?:\ (?:as|as\ in|with))?\ --[a-z][a-z-]*(?:\ [\w.]+=(?:'[^']*'|[^\s;,)]+)|\ [\w.-]*\d[\w.-]*)?""",
    re.VERBOSE,
)
"""What a message says to who types commands."""


def on_the_page(words: str) -> str:
    """Leave out of a message the options and commands that nobody can type on the page."""
    return OPTION.sub("", words)


class WorkerPool:
    """A few workers that share the tasks; those of one key go to the one whose cache knows it where it is free.

    What a task failed of is said as `on_the_page`.
    """

    def __init__(self, settings: Settings, most: int = MOST) -> None:
        self._settings = settings
        self._workers = [Worker(settings) for _ in range(most)]
        self._free = asyncio.Condition()
        self._threads = ThreadPoolExecutor(2 * most, "workers")  # some wait for a worker that is ended

    async def do(self, key: str, task: Task, *arguments: Any, say: Say = silent) -> Any:
        """Do a task when a worker is free; `say` is called in this loop. Raises Failed; cancelled, it ends the worker."""
        loop, worker = asyncio.get_running_loop(), await self._take(key)

        def said(content: Any) -> None:
            loop.call_soon_threadsafe(say, content)

        try:
            return await loop.run_in_executor(self._threads, worker.do, task, arguments, said)
        except (asyncio.CancelledError, Ended):
            worker.end()  # nothing here waits: who cancels twice would interrupt it
            _finish_changes(arguments)
            self._workers[self._workers.index(worker)] = Worker(self._settings)
            raise
        except Failed as failure:
            raise Failed(on_the_page(str(failure))) from None
        finally:
            async with self._free:
                worker.busy = False
                self._free.notify()

    async def _take(self, key: str) -> Worker:
        async with self._free:
            await self._free.wait_for(lambda: not all(worker.busy for worker in self._workers))
            idle = [worker for worker in self._workers if not worker.busy]
            worker = next((w for w in idle if key in w.served), min(idle, key=lambda w: len(w.served)))
            worker.busy = True
            worker.served.add(key)
            return worker

    async def warm(self, task: Task) -> None:
        """Let one worker after the other do a task that compiles what it will need."""
        with contextlib.suppress(Failed):
            for number in range(len(self._workers)):
                await self.do(f"warm {number}", task)

    def end(self) -> None:
        """End all workers."""
        for worker in self._workers:
            worker.end()
        self._threads.shutdown(wait=False, cancel_futures=True)
