"""Tasks share workers; whoever waits for one can be cancelled at once, and a diagnosis by a command is seen."""

import asyncio
import threading
from collections.abc import Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from station.settings import Settings
from station.workbench import worker
from station.workbench.session_state import SessionState


def alone(story: Callable[[], Coroutine[Any, Any, Any]]) -> Any:
    """Run a story in a loop of its own; the browser's driver keeps one in this thread."""
    with ThreadPoolExecutor(1) as threads:
        return threads.submit(lambda: asyncio.run(story())).result(30)


class Occupied:
    """A worker whose task ends when it is let go."""

    gate = threading.Event()

    def __init__(self, settings: Settings) -> None:
        self.served: set[str] = set()
        self.busy, self.alive = False, True

    def do(self, task: str, arguments: tuple[Any, ...], progress: worker.Progress) -> str:
        assert self.gate.wait(60)
        return task

    def end(self) -> None:
        self.gate.set()


def test_a_task_that_waits_for_a_worker_is_cancelled_at_once(monkeypatch):
    monkeypatch.setattr(worker, "Worker", Occupied)
    Occupied.gate = threading.Event()

    async def story() -> None:
        pool = worker.WorkerPool(Settings(), most=1)
        first = asyncio.create_task(pool.do(worker.Job(), "a", "long"))
        await asyncio.sleep(0.05)
        job = worker.Job()
        second = asyncio.create_task(pool.do(job, "b", "waiting"))
        await asyncio.sleep(0.05)
        job.cancel()
        with pytest.raises(worker.Cancelled):
            await second
        assert not first.done()  # it still holds the only worker: the second did not wait for it
        Occupied.gate.set()
        assert await first == "long"
        pool.end()

    alone(story)


@dataclass
class Named:
    """A model by the names of its effects."""

    effects: list[str]


@dataclass
class Top:
    """A ladder of which only the present model matters."""

    top: Named


@dataclass
class Asked:
    """A diagnosis: only its identity and that it has suspects matter here."""

    model: Named
    suspects: tuple[str, ...] = ("any",)


@dataclass
class Looked:
    """What a look at a session returns: only its diagnosis matters here."""

    diagnosis: Asked | None
    ladder: Top = field(default_factory=lambda: Top(Named([])))
    about_present: bool = True
    at_floor: bool = False
    note: str = ""
    frames: dict[str, str] = field(default_factory=lambda: {"rung": "drawn"})
    rung_frames: tuple[str, ...] = ("rung",)


@dataclass
class Answering:
    """A pool that answers each task with what was prepared for it."""

    answers: dict[str, Any]
    asked: list[str] = field(default_factory=list)

    async def do(self, job: Any, key: str, task: str, *arguments: Any, progress: Any = None) -> Any:
        self.asked.append(task)
        return self.answers[task]


def test_frames_are_drawn_again_when_a_command_has_diagnosed_since():
    async def story() -> None:
        pool = Answering({})
        session = SessionState(Path("none"), pool)  # type: ignore[arg-type]
        for diagnosis, drawn in ((["a"], "first"), (["b"], "second"), (["b"], "second")):
            frames = ({drawn: "frame"}, {diagnosis[0]: drawn})
            pool.answers = {"look": Looked(Asked(Named(diagnosis)), Top(Named(diagnosis))), "frames": frames}
            assert session.start("Reading", "look")
            await asyncio.gather(*session._tasks)
            assert session.suspect_frames == {diagnosis[0]: drawn}
            assert drawn in session.frames
        assert pool.asked.count("frames") == 2  # not a third time: nothing had changed

    alone(story)
