"""Sessions analysed by processes of this computer; one that is killed costs no other session."""

import asyncio
import os
from collections.abc import Callable, Generator, Iterable
from contextlib import closing
from itertools import islice

from station.campaign.work import Work, perform
from station.operations.workers import Ended, Failed, Say, WorkerPool
from station.results.campaign_document import SessionResult
from station.settings import Settings

AHEAD = 2
KILLED = "its worker was killed twice: too little memory?"
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")

Act = Callable[[Work], SessionResult]
Answer = tuple[Work, SessionResult | str]
"""A session with its result, or with the reason why the program or the computer gave none."""


def performed(works: Iterable[Work], workers: int, act: Act = perform) -> Generator[Answer, None, None]:
    """Yield the answers as they come from so many processes, each with one thread of numerics; 0: from this process.

    A session whose process is killed is done once more. Where the generator is closed early, what is under way is dropped.
    """
    if not workers:
        yield from ((work, act(work)) for work in works)
        return
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))  # libraries read it when a process imports them
    waiting, pool = iter(works), WorkerPool(Settings(), workers)
    under_way: dict[asyncio.Task[SessionResult | str], Work] = {}
    with closing(asyncio.new_event_loop()) as loop:
        try:
            while True:
                for work in islice(waiting, AHEAD * workers - len(under_way)):
                    under_way[loop.create_task(_answer(pool, act, work))] = work
                if not under_way:
                    return
                wait = asyncio.wait(under_way, return_when=asyncio.FIRST_COMPLETED)
                for done in loop.run_until_complete(wait)[0]:
                    yield under_way.pop(done), done.result()
        finally:
            for task in under_way:
                task.cancel()
            if under_way:
                loop.run_until_complete(asyncio.wait(under_way))
            pool.end()


async def _answer(pool: WorkerPool, act: Act, work: Work) -> SessionResult | str:
    for _ in range(2):
        try:
            result: SessionResult = await pool.do("", _alone, act, work)
            return result
        except Ended:
            continue
        except Failed as failure:  # a fault of the program on one session does not end the campaign
            return str(failure)
    return KILLED


def _alone(settings: Settings, say: Say, act: Act, work: Work) -> SessionResult:
    return act(work)


def cores() -> int:
    """Count how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
