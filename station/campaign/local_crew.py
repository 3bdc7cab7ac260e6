"""Workers on the cores of this computer; one that is killed is replaced, and its sessions are done again."""

import multiprocessing
import os
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from itertools import islice

from station.campaign.crew import Answers
from station.campaign.work import Answer, Work, perform
from station.campaign.worker_process import begin

AHEAD = 2
MOST_DEATHS = 2

KILLED = f"its worker was killed {MOST_DEATHS} times while it did nothing else: too little memory?"


class LocalCrew:
    """A pool of processes, each with one thread of numerics.

    When a process dies the pool is gone, and with it who had what: the sessions that were under way are then done one
    at a time, so that the one that kills its worker is found and costs no other.
    """

    def __init__(self, workers: int, act: Callable[[Work], str] = perform) -> None:
        self.workers = workers
        self._act = act

    def performed(self, works: Iterable[Work]) -> Answers:
        """Yield the answers; see `Crew`."""
        waiting, deaths = iter(works), Counter[str]()
        while suspects := (yield from self._until_a_death(waiting, self.workers, AHEAD * self.workers)):
            while suspects:
                others = iter(suspects)
                killers = yield from self._until_a_death(others, workers=1, at_once=1)
                deaths.update(work.key for work in killers)
                failed = [work for work in killers if deaths[work.key] >= MOST_DEATHS]
                yield from (Answer(work, problem=KILLED) for work in failed)
                suspects = [*(work for work in killers if work not in failed), *others]

    def _until_a_death(
        self, works: Iterator[Work], workers: int, at_once: int
    ) -> Generator[Answer, None, list[Work]]:
        """Yield answers of a pool until one of its processes dies; return the sessions that were under way then."""
        others = set(multiprocessing.active_children())
        pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), initializer=begin)
        under_way: dict[Future[str], Work] = {}
        try:
            while True:
                for work in islice(works, at_once - len(under_way)):
                    under_way[pool.submit(self._act, work)] = work
                if not under_way:
                    return []
                done, _ = wait(under_way, return_when=FIRST_COMPLETED)
                for future in done:
                    work = under_way.pop(future)
                    yield _answer(work, future)
        except BrokenProcessPool:
            return [work, *under_way.values()]
        except BaseException:  # interrupted: in the middle of their work
            for process in set(multiprocessing.active_children()) - others:
                process.terminate()
            raise
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def _answer(work: Work, future: Future[str]) -> Answer:
    try:
        return Answer(work, future.result())
    except BrokenProcessPool:
        raise
    except Exception as error:  # a fault of the program on one session does not end the campaign
        return Answer(work, problem=f"{type(error).__name__}: {error}")


def cores() -> int:
    """Count how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
