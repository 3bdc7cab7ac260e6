"""Sessions analysed by processes of this computer; one that is killed costs no other session."""

import os
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from itertools import islice

from station.campaign.work import Work, perform
from station.operations.workers import Ended, Failed, Say, Worker
from station.results.campaign_document import SessionResult
from station.settings import Settings
from station.story.pipeline import silent

KILLED = "its worker was killed twice, the second time while it did nothing else: too little memory?"
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")

Act = Callable[[Work], SessionResult]
Answer = tuple[Work, SessionResult | str]
"""A session with its result, or with the reason why the program or the computer gave none."""


def performed(works: Iterable[Work], workers: int, act: Act = perform) -> Generator[Answer, None, None]:
    """Yield the answers as they come from so many processes, each with one thread of numerics; 0: from this process.

    A session whose process was killed is done again at the end, alone, so that it costs no other one. Where the generator
    is closed early, what is under way is dropped.
    """
    if not workers:
        yield from ((work, act(work)) for work in works)
        return
    killed: list[Work] = []
    for work, answer in _answers(iter(works), workers, act):
        if answer is KILLED:
            killed.append(work)
        else:
            yield work, answer
    for work in killed:
        yield from _answers(iter([work]), 1, act)


def _answers(works: Iterator[Work], workers: int, act: Act) -> Generator[Answer, None, None]:
    """Yield the answers of some workers; KILLED for a session whose worker was killed, in whose place another one steps."""
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))  # libraries read it when a process imports them
    idle = [Worker(Settings()) for _ in range(workers)]
    under_way: dict[Future[SessionResult], tuple[Work, Worker]] = {}
    with ThreadPoolExecutor(workers) as threads:
        try:
            while True:
                for work in islice(works, len(idle)):
                    worker = idle.pop()
                    under_way[threads.submit(worker.do, _act, (act, work), silent)] = work, worker
                if not under_way:
                    return
                for future in wait(under_way, return_when=FIRST_COMPLETED).done:
                    work, worker = under_way.pop(future)
                    answer: SessionResult | str
                    try:
                        answer = future.result()
                    except Ended:
                        answer, worker = KILLED, Worker(Settings())
                    except (
                        Failed
                    ) as failure:  # a fault of the program on one session does not end the campaign
                        answer = str(failure)
                    idle.append(worker)
                    yield work, answer
        finally:
            for worker in (*idle, *(worker for _, worker in under_way.values())):
                worker.end()


def _act(settings: Settings, say: Say, act: Act, work: Work) -> SessionResult:
    """Do the work on a session, as a task of a worker."""
    return act(work)


def cores() -> int:
    """Count how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
