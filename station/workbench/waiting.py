"""A place of the page in which one task at a time is done: what it does meanwhile, and a way to cancel it."""

from typing import Any

from station.workbench import widgets
from station.workbench.worker import Job, WorkerPool


class Waiting:
    """A line that is seen only while its task is done; `job` is that task."""

    def __init__(self, workers: WorkerPool) -> None:
        self._workers = workers
        self._words = ""
        self.job: Job | None = None

    def build(self) -> None:
        """Make the line, empty."""
        self._place = widgets.line().props("aria-live=polite")

    async def do(self, words: str, key: str, task: str, *arguments: Any) -> Any:
        """Do a task and return its result, saying `words`, then what it says of itself; raises Failed or Cancelled."""
        self._words, job = words, Job()
        self.job = job
        self._place.clear()
        with self._place:
            widgets.spinner()
            widgets.label("", "small grow wrap").bind_text_from(self, "_words")
            widgets.button("Cancel", job.cancel)
        try:
            return await self._workers.do(job, key, task, *arguments, progress=self._note)
        finally:
            if self.job is job:
                self.job = None
                self._place.clear()

    def cancel(self) -> None:
        """End the task where one is under way."""
        if self.job is not None:
            self.job.cancel()

    def _note(self, words: str) -> None:
        self._words = words
