"""Workers of a Dask cluster that is there already; a session whose worker is lost is done by another."""

import logging
import queue
import time
import warnings
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import CancelledError
from contextlib import contextmanager
from itertools import islice
from typing import Any

from station.campaign.crew import Answers
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
LOST = (OSError, TimeoutError, RuntimeError, CancelledError)
"""What the client raises where its scheduler is gone."""


class DaskCrew:
    """The workers behind the scheduler at an address, as "tcp://host:8786".

    Sessions are sent with their content and answers come back, so that a worker needs the program and no folder of
    ours. `patience` is how many seconds the cluster may be without a worker; `workers` counts its threads.
    """

    def __init__(
        self, address: str, act: Callable[[Work], str] = perform, patience: float = PATIENCE_S
    ) -> None:
        self._address = address
        self._act = act
        self._patience = patience
        self._seen = 0.0
        self.workers = 0

    def performed(self, works: Iterable[Work]) -> Answers:
        """Yield the answers; see `Crew`. UsageProblem where the package, the scheduler or all of its workers are missing."""
        waiting, finished = iter(works), queue.SimpleQueue[Any]()
        under_way: dict[Any, Work] = {}
        with self._connected() as client:
            while True:
                self._look(client)
                for work in islice(
                    waiting, max(AHEAD * self.workers, FEWEST, len(under_way)) - len(under_way)
                ):
                    with warnings.catch_warnings():
                        warnings.simplefilter("ignore")  # that a session's content is large
                        future = client.submit(self._act, work, pure=False)
                    under_way[future] = work
                    future.add_done_callback(finished.put)
                if not under_way:
                    return
                try:
                    future = finished.get(timeout=LOOK_S)
                except queue.Empty:
                    continue
                yield self._answer(under_way.pop(future), future)

    def _answer(self, work: Work, future: Any) -> Answer:
        from distributed import KilledWorker

        if future.status == "finished":
            return Answer(work, str(future.result()))
        if future.status != "error":  # cancelled or lost, with the scheduler
            raise self._gone()
        error = future.exception()
        if isinstance(error, KilledWorker):
            return Answer(work, problem="several workers were killed on it: too little memory?")
        if isinstance(error, ImportError):
            raise UsageProblem(
                f"the workers at {self._address} do not have this program ({error}): install it there, the same version"
            )
        return Answer(work, problem=f"{type(error).__name__}: {error}")

    def _look(self, client: Any) -> None:
        """Ask the scheduler who is there; UsageProblem when nobody has been for too long."""
        try:
            self.workers = sum(client.nthreads().values())
        except LOST as error:
            raise self._gone() from error
        if self.workers:
            self._seen = time.monotonic()
        elif time.monotonic() - self._seen > self._patience:
            raise UsageProblem(
                f"no worker is left at {self._address}; start some (dask worker {self._address}) and run the same "
                "command again: finished sessions are kept"
            )

    def _gone(self) -> UsageProblem:
        return UsageProblem(
            f"the scheduler at {self._address} is gone; start it and its workers and run the same command again: "
            "finished sessions are kept"
        )

    @contextmanager
    def _connected(self) -> Generator[Any, None, None]:
        """Connect to the scheduler; disconnect at the end, which drops what is under way there."""
        try:
            from distributed import Client
        except ImportError as error:
            raise UsageProblem(MISSING) from error
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        try:
            client = Client(self._address, timeout=CONNECT_S, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise UsageProblem(
                f"no Dask scheduler answers at {self._address}; give the address that `dask scheduler` prints"
            ) from error
        self._seen = time.monotonic()
        try:
            yield client
        finally:
            try:
                client.close(timeout=CONNECT_S)
            except LOST as problem:  # it is gone already
                logging.getLogger(__name__).debug("closing: %s", problem)
