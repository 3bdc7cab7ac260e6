"""One run of a campaign: missing or changed results are computed and kept at once, the others are read."""

import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, field
from typing import Protocol

from daq.errors import StationError
from station.campaign.crew import Crew
from station.campaign.kept import Kept
from station.campaign.sources import Source
from station.campaign.work import Work
from station.results.campaign_document import FailedSession, SessionResult
from station.settings import Settings


class Observer(Protocol):
    """An observer of the progress of a run."""

    def kept(self, name: str) -> None:
        """A session had been done before."""

    def done(self, name: str) -> None:
        """A session has been done."""

    def failed(self, name: str, reason: str) -> None:
        """A session has no result."""


@dataclass(frozen=True)
class Request:
    """The analysis that every session gets."""

    settings: Settings
    gain_percent: float | None = None
    diagnose: bool = False


@dataclass
class Run:
    """The result of a run: each source with its result, those without one, and the time that it took."""

    results: list[tuple[Source, SessionResult]] = field(default_factory=list)
    failed: list[FailedSession] = field(default_factory=list)
    done: int = 0
    kept: int = 0
    workers: int = 0
    wall_s: float = 0.0
    work_s: float = 0.0


def run_campaign(
    sources: tuple[Source, ...], request: Request, crew: Crew, kept: Kept, observer: Observer
) -> Run:
    """Bring the results of all sources up to date; each is kept the moment it is there.

    StorageError when the folder of the campaign cannot be written; Problem when the crew is gone.
    """
    run, under_way = Run(), {}
    began = time.monotonic()

    def fail(source: Source, reason: str) -> None:
        run.failed.append(FailedSession(session=source.name, reason=reason))
        observer.failed(source.name, reason)

    def take(source: Source, result: SessionResult) -> None:
        if result.reason:
            fail(source, result.reason)
        else:
            run.results.append((source, result))

    def missing() -> Iterator[Work]:
        for source in sources:
            try:
                if source.info is None:
                    raise StationError(source.problem or "its metadata cannot be read")
                work = source.work(request.settings, request.gain_percent, request.diagnose)
            except StationError as error:
                fail(source, " ".join(str(error).split()))
                continue
            known = kept.read(source.name, work.key)
            if known is None:
                under_way[id(work)] = source
                yield work
                continue
            run.kept += 1
            if not known.reason:
                observer.kept(source.name)
            take(source, known)

    kept.make()
    with closing(crew.performed(missing())) as answers:
        for answer in answers:
            source = under_way.pop(id(answer.work))
            run.workers = max(run.workers, crew.workers)
            if answer.problem:
                fail(source, answer.problem)
                continue
            try:
                result = SessionResult.model_validate_json(answer.result)
            except ValueError:
                fail(source, "its worker runs another version of this program, whose answer cannot be read")
                continue
            kept.write(source.name, answer.work.key, answer.result)
            run.done += 1
            run.work_s += result.seconds
            take(source, result)
            if not result.reason:
                observer.done(source.name)
    run.wall_s = time.monotonic() - began
    return run
