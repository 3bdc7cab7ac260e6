"""Workers on the cores of this computer; one that is killed is replaced, and its sessions are done again."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.process import BaseProcess
from types import TracebackType
from typing import Self

from station.campaign.work import Answer, Work, perform
from station.library_messages import say_in_one_line

ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
AHEAD = 2
MOST_DEATHS = 2

KILLED = f"its worker was killed {MOST_DEATHS} times while it was alone at it: too little memory?"


class LocalCrew:
    """A pool of processes, each with one thread of numerics.

    When a process dies the pool is gone, and with it who had what: the sessions that were under way are then done one
    at a time, so that the one that kills its worker is found and costs no other.
    """

    def __init__(self, workers: int, act: Callable[[Work], str] = perform) -> None:
        self._count = workers
        self._act = act
        self._pool: ProcessPoolExecutor | None = None
        self._under_way: dict[Future[str], Work] = {}
        self._suspects: list[Work] = []
        self._deaths: dict[str, int] = {}
        self._before: dict[str, str | None] = {}
        self._others: set[BaseProcess] = set()

    @property
    def workers(self) -> int:
        """How many processes there are."""
        return self._count

    @property
    def wanted(self) -> int:
        """How many more sessions keep them busy; none while it is looked for the one that kills its worker."""
        return 0 if self._suspects else max(AHEAD * self._count - len(self._under_way), 0)

    @property
    def busy(self) -> bool:
        """Whether an answer is still to come."""
        return bool(self._under_way or self._suspects)

    def submit(self, work: Work) -> None:
        """Hand a session over."""
        try:
            future = self._running().submit(self._act, work)
        except (
            BrokenProcessPool
        ):  # a process died while it had nothing to do, or another's death is not known yet
            self._stop()
            future = self._running().submit(self._act, work)
        self._under_way[future] = work

    def answers(self) -> list[Answer]:
        """Wait for the next answers; none where all that happened is that a process died."""
        if not self._under_way:
            self.submit(self._suspects.pop(0))
        alone = len(self._under_way) == 1
        done, _ = wait(self._under_way, return_when=FIRST_COMPLETED)
        found, lost = [], []
        for future in done:
            work = self._under_way.pop(future)
            try:
                found.append(Answer(work, future.result()))
            except BrokenProcessPool:
                lost.append(work)
            except Exception as error:  # a fault of the program on one session does not end the campaign
                found.append(Answer(work, problem=f"{type(error).__name__}: {error}"))
        if lost and alone:
            found += self._killed(lost[0])
        elif lost:
            self._suspects += [*lost, *self._under_way.values()]
            self._under_way = {}
        if lost:
            self._stop()
        return found

    def _killed(self, work: Work) -> list[Answer]:
        """Try a session again that was alone with a worker that died; once it has had its chances it has failed."""
        self._deaths[work.key] = self._deaths.get(work.key, 0) + 1
        if self._deaths[work.key] >= MOST_DEATHS:
            return [Answer(work, problem=KILLED)]
        self._suspects.insert(0, work)
        return []

    def _running(self) -> ProcessPoolExecutor:
        if self._pool is None:
            context = multiprocessing.get_context("spawn")
            self._pool = ProcessPoolExecutor(self._count, context, initializer=_begin)
        return self._pool

    def _stop(self) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=False, cancel_futures=True)
            self._pool = None

    def __enter__(self) -> Self:
        """Let processes that are started from now on have one thread of numerics each."""
        self._before = {name: os.environ.get(name) for name in ONE_THREAD}
        self._others = set(multiprocessing.active_children())
        os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the processes; in the middle of their work where the campaign was interrupted."""
        self._stop()
        if error is not None:
            for process in set(multiprocessing.active_children()) - self._others:
                process.terminate()
        for name, value in self._before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def cores() -> int:
    """Count how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _begin() -> None:
    """Leave Ctrl-C to the process that gave the work, and end with it, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    say_in_one_line()
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
