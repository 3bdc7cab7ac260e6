"""Sessions analysed by processes of this computer; one that is killed costs no other session."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from itertools import islice

from station.campaign.work import Work, perform
from station.output import say_in_one_line
from station.results.campaign_document import SessionResult

AHEAD = 2
KILLED = "its worker was killed twice, the second time while it did nothing else: too little memory?"
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")

Answer = tuple[Work, SessionResult | str]
"""A session with its result, or with the reason why the program or the computer gave none."""


def performed(
    works: Iterable[Work], workers: int, act: Callable[[Work], SessionResult] = perform
) -> Generator[Answer, None, None]:
    """Yield the answers as they come from so many processes, each with one thread of numerics; 0: from this process.

    When a process dies the pool is gone, and with it who had what: each session that was under way is then done alone, so
    that the one that kills its worker is found. Where the generator is closed early, what is under way is dropped.
    """
    if not workers:
        yield from ((work, act(work)) for work in works)
        return
    waiting = iter(works)
    while suspects := (yield from _until_a_death(waiting, workers, act)):
        for work in suspects:
            if (yield from _until_a_death(iter([work]), 1, act)):
                yield work, KILLED


def _until_a_death(
    works: Iterator[Work], workers: int, act: Callable[[Work], SessionResult]
) -> Generator[Answer, None, list[Work]]:
    """Yield answers of a pool until one of its processes dies; return the sessions that were under way then."""
    others = set(multiprocessing.active_children())
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))  # libraries read it when a process imports them
    pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), initializer=_begin)
    under_way: dict[Future[SessionResult], Work] = {}
    try:
        while True:
            for work in islice(works, AHEAD * workers - len(under_way)):
                under_way[pool.submit(act, work)] = work
            if not under_way:
                return []
            for future in wait(under_way, return_when=FIRST_COMPLETED).done:
                work = under_way.pop(future)
                try:
                    yield work, future.result()
                except BrokenProcessPool:
                    raise
                except Exception as error:  # a fault of the program on one session does not end the campaign
                    yield work, f"{type(error).__name__}: {error}"
    except BrokenProcessPool:
        return [work, *under_way.values()]
    except BaseException:  # interrupted: in the middle of their work
        for process in set(multiprocessing.active_children()) - others:
            process.terminate()
        raise
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


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


def cores() -> int:
    """Count how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
