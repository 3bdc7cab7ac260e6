"""A crew: workers that take sessions and give answers, on this computer or on a cluster."""

from collections.abc import Iterable, Iterator
from types import TracebackType
from typing import Protocol, Self

from station.campaign.work import Answer, Work, perform


class Crew(Protocol):
    """Workers; sessions that a lost worker had are done by the others."""

    @property
    def workers(self) -> int:
        """How many there are now."""

    @property
    def wanted(self) -> int:
        """How many more sessions keep them busy."""

    @property
    def busy(self) -> bool:
        """Whether an answer is still to come."""

    def submit(self, work: Work) -> None:
        """Hand a session over."""

    def answers(self) -> list[Answer]:
        """Wait for the next answers; Problem when there is nobody left who could give one."""

    def __enter__(self) -> Self:
        """Begin."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Send everybody home; what is under way is dropped."""


class InThisProcess:
    """A crew of this process alone: one session after another."""

    workers = 1

    def __init__(self) -> None:
        self._waiting: list[Work] = []

    @property
    def wanted(self) -> int:
        """How many more sessions keep it busy."""
        return 1 - len(self._waiting)

    @property
    def busy(self) -> bool:
        """Whether an answer is still to come."""
        return bool(self._waiting)

    def submit(self, work: Work) -> None:
        """Hand a session over."""
        self._waiting.append(work)

    def answers(self) -> list[Answer]:
        """Return the answer of the session that was handed over."""
        work = self._waiting.pop()
        return [Answer(work, perform(work))]

    def __enter__(self) -> Self:
        """Begin."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End."""


def perform_all(works: Iterable[Work], crew: Crew) -> Iterator[Answer]:
    """Give sessions to a crew, no more at once than keep it busy, and yield the answers as they come."""
    waiting = iter(works)
    more = True
    while more or crew.busy:
        for _ in range(crew.wanted if more else 0):
            work = next(waiting, None)
            if work is None:
                more = False
                break
            crew.submit(work)
        if crew.busy:
            yield from crew.answers()
