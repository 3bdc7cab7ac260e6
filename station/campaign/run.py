"""One run of a campaign: missing or changed results are computed by processes and kept at once, the others are read."""

import os
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import closing
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

from daq.errors import StationError
from daq.session import SessionSummary
from daq.storage import read_regular, refused, write_whole
from station.campaign.work import Work, perform, work_on
from station.operations.workers import Ended, Failed, Say, Worker
from station.results.campaign_document import SessionResult
from station.results.documents import LARGEST, RefusedSession
from station.results.sessions import safe_name
from station.settings import Settings
from station.story.pipeline import silent

SESSIONS = "sessions"
KILLED = "its worker was killed twice, the second time while it did nothing else: too little memory?"
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")

Watch = Callable[[str, str], None]
"""Called for each session with its name and the reason why it has no result, "" where it has one."""

Act = Callable[[Work], SessionResult]
Answer = tuple[Work, SessionResult | str]
"""A session with its result, or with the reason why the program or the computer gave none."""


@dataclass
class Run:
    """The result of a run: each source with its result, those without one, and the time that it took."""

    results: list[tuple[SessionSummary, SessionResult]] = field(default_factory=list)
    failed: list[RefusedSession] = field(default_factory=list)
    done: int = 0
    kept: int = 0
    workers: int = 0
    wall_s: float = 0.0
    work_s: float = 0.0


def run_campaign(
    sources: tuple[SessionSummary, ...],
    settings: Settings,
    folder: Path,
    workers: int,
    watch: Watch = silent,
    *,
    diagnose: bool = False,
) -> Run:
    """Bring the results of all sources up to date; each is kept in `folder` the moment it is there.

    `workers` is how many processes work, 0 for this one. StorageError when the folder cannot be written.
    """
    run, under_way = Run(workers=max(workers, 1)), dict[Work, SessionSummary]()
    began = time.monotonic()

    def take(source: SessionSummary, result: SessionResult | str) -> None:
        reason = result if isinstance(result, str) else result.reason
        if isinstance(result, str) or reason:
            run.failed.append(RefusedSession(session=source.folder.name, reason=reason))
        else:
            run.results.append((source, result))
        watch(source.folder.name, reason)

    def missing() -> Iterator[Work]:
        for source in sources:
            try:
                if source.info is None:
                    raise StationError(source.problem or "its metadata cannot be read")
                work = work_on(source.folder, settings, diagnose)
            except StationError as error:
                take(source, " ".join(str(error).split()))
                continue
            known = _kept(_file(folder, work), work.key)
            if known is None:
                under_way[work] = source
                yield work
            else:
                run.kept += 1
                take(source, known)

    try:
        (folder / SESSIONS).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise refused(folder, error) from error
    with closing(performed(missing(), workers)) as answers:
        for work, result in answers:
            if not isinstance(result, str):
                write_whole(_file(folder, work), result.model_dump_json(indent=1).encode() + b"\n")
                run.done += 1
                run.work_s += result.seconds
            take(under_way.pop(work), result)
    run.wall_s = time.monotonic() - began
    return run


def _file(folder: Path, work: Work) -> Path:
    """Return the file in which the result of a session is kept, by the key of its content and the settings."""
    return folder / SESSIONS / f"{safe_name(work.folder.name)}-{work.key[:16]}.json"


def _kept(file: Path, key: str) -> SessionResult | None:
    """Read the result of a session; None where there is none that can be read: it is made again."""
    try:
        found = SessionResult.model_validate_json(read_regular(file, LARGEST))
    except (StationError, ValueError):
        return None
    return found if found.key == key else None


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
                    except Failed as failure:  # a fault of the program: the campaign goes on
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
