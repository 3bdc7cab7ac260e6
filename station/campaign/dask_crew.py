"""Workers of a Dask cluster that is there already; a session whose worker is lost is done by another."""

import logging
import queue
import time
import warnings
from collections.abc import Callable
from concurrent.futures import CancelledError
from types import TracebackType
from typing import Any, Self

from station.campaign.work import Answer, Work, perform
from station.exits import UsageProblem

MISSING = (
    "--scheduler needs the package distributed, which is not installed here; type: pip install distributed"
)
CONNECT_S = 10.0
PATIENCE_S = 30.0
LOOK_S = 2.0
AHEAD = 2
FEWEST = 4


class DaskCrew:
    """The workers behind the scheduler at an address, as "tcp://host:8786".

    Sessions are sent with their content and answers come back, so that a worker needs the program and no folder of
    ours. `patience` is how many seconds the cluster may be without a worker.
    """

    def __init__(
        self, address: str, act: Callable[[Work], str] = perform, patience: float = PATIENCE_S
    ) -> None:
        self._address = address
        self._act = act
        self._patience = patience
        self._client: Any = None
        self._under_way: dict[Any, Work] = {}
        self._finished: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._threads: dict[str, int] = {}
        self._looked = 0.0
        self._seen = 0.0

    @property
    def workers(self) -> int:
        """How many threads of workers there are."""
        return sum(self._threads.values())

    @property
    def wanted(self) -> int:
        """How many more sessions keep them busy."""
        self._look()
        return max(max(AHEAD * self.workers, FEWEST) - len(self._under_way), 0)

    @property
    def busy(self) -> bool:
        """Whether an answer is still to come."""
        return bool(self._under_way)

    def submit(self, work: Work) -> None:
        """Hand a session over."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that a session's content is large
            future = self._client.submit(self._act, work, pure=False)
        self._under_way[future] = work
        future.add_done_callback(self._finished.put)

    def answers(self) -> list[Answer]:
        """Wait for the next answers; UsageProblem when the scheduler or all of its workers are gone."""
        while True:
            try:
                future = self._finished.get(timeout=LOOK_S)
            except queue.Empty:
                self._look(now=True)
                continue
            self._seen = time.monotonic()
            return [self._answer(future)]

    def _answer(self, future: Any) -> Answer:
        from distributed import KilledWorker

        work = self._under_way.pop(future)
        if future.status == "finished":
            return Answer(work, str(future.result()))
        if future.status != "error":  # cancelled or lost, with the scheduler
            raise self._gone()
        error = future.exception()
        if isinstance(error, KilledWorker):
            return Answer(work, problem="several workers were killed while they had it: too little memory?")
        if isinstance(error, ImportError):
            raise UsageProblem(
                f"the workers at {self._address} do not have this program ({error}): install it there, the same version"
            )
        return Answer(work, problem=f"{type(error).__name__}: {error}")

    def _look(self, now: bool = False) -> None:
        """Ask the scheduler who is there; UsageProblem when nobody has been for too long."""
        at = time.monotonic()
        if not now and at - self._looked < LOOK_S:
            return
        try:
            self._threads = dict(self._client.nthreads())
        except (OSError, TimeoutError, RuntimeError, CancelledError) as error:
            raise self._gone() from error
        self._looked = at
        if self._threads:
            self._seen = at
        elif at - self._seen > self._patience:
            raise UsageProblem(
                f"no worker is left at {self._address}; start some (dask worker {self._address}) and run the same "
                "command again: what is done is kept"
            )

    def _gone(self) -> UsageProblem:
        return UsageProblem(
            f"the scheduler at {self._address} is gone; start it and its workers and run the same command again: "
            "what is done is kept"
        )

    def __enter__(self) -> Self:
        """Connect; UsageProblem when the package is missing or nobody answers."""
        try:
            from distributed import Client
        except ImportError as error:
            raise UsageProblem(MISSING) from error
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        try:
            self._client = Client(self._address, timeout=CONNECT_S, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise UsageProblem(
                f"no Dask scheduler answers at {self._address}; give the address that `dask scheduler` prints"
            ) from error
        self._seen = time.monotonic()
        self._look(now=True)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Drop what is under way and disconnect; the cluster stays."""
        if self._client is not None:
            try:
                self._client.cancel(list(self._under_way))
                self._client.close(timeout=CONNECT_S)
            except (OSError, TimeoutError, RuntimeError, CancelledError) as problem:  # it is gone already
                logging.getLogger(__name__).debug("closing: %s", problem)
