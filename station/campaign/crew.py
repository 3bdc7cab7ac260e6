"""A crew: workers that take sessions and give answers, on this computer or on a cluster."""

from collections.abc import Generator, Iterable
from typing import Protocol

from station.campaign.work import Answer, Work, perform

Answers = Generator[Answer, None, None]


class Crew(Protocol):
    """Workers; sessions that a lost worker had are done by the others."""

    @property
    def workers(self) -> int:
        """How many there are now."""

    def performed(self, works: Iterable[Work]) -> Answers:
        """Take sessions, no more at once than keep the workers busy, and yield the answers as they come.

        Where it is closed early, what is under way is dropped. Raises Problem when nobody is left who could answer.
        """


class InThisProcess:
    """A crew of this process alone: one session after another."""

    workers = 1

    def performed(self, works: Iterable[Work]) -> Answers:
        """Yield the answers; see `Crew`."""
        for work in works:
            yield Answer(work, perform(work))
