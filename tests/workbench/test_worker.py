"""Tasks share workers; whoever waits for one can be cancelled at once, and a diagnosis by a command is seen."""

import asyncio
import threading
from collections.abc import Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from station.operations import workers as worker
from station.operations.workers import on_the_page
from station.settings import Settings
from station.workbench import tasks
from station.workbench.session_state import AppState, SessionState
from station.workbench.view_models import Drawn, View


def alone(story: Callable[[], Coroutine[Any, Any, Any]]) -> Any:
    """Run a story in a loop of its own; the browser's driver keeps one in this thread."""
    with ThreadPoolExecutor(1) as threads:
        return threads.submit(lambda: asyncio.run(story())).result(30)


class Occupied:
    """A worker whose task ends when it is let go."""

    gate = threading.Event()

    def __init__(self, settings: Settings) -> None:
        self.served: set[str] = set()
        self.busy = False

    def do(self, task: str, arguments: tuple[Any, ...], say: worker.Say) -> str:
        assert self.gate.wait(60)
        return task

    def end(self) -> None:
        self.gate.set()


def test_a_task_that_waits_for_a_worker_is_cancelled_at_once(monkeypatch):
    monkeypatch.setattr(worker, "Worker", Occupied)
    Occupied.gate = threading.Event()

    async def story() -> None:
        pool = worker.WorkerPool(Settings(), most=1)
        first = asyncio.create_task(pool.do("a", "long"))
        await asyncio.sleep(0.05)
        second = asyncio.create_task(pool.do("b", "waiting"))
        await asyncio.sleep(0.05)
        second.cancel()
        with pytest.raises(asyncio.CancelledError):
            await second
        assert not first.done()  # it still holds the only worker: the second did not wait for it
        Occupied.gate.set()
        assert await first == "long"
        pool.end()

    alone(story)


def looked(*asked: str, present: str = "", stamp: tuple[int, ...] = ()) -> View:
    """Return what a look at a session returns: only its diagnosis matters here, of a model by the names of its effects."""
    diagnosis = (
        SimpleNamespace(model=SimpleNamespace(effects=list(asked)), suspects=("any",)) if asked else None
    )
    top = SimpleNamespace(effects=[present] if present else list(asked), at_floor=False)
    ladder: Any = SimpleNamespace(top=top, present=0, steps=())
    return View(ladder, diagnosis, stamp=stamp, frames={"step": {}}, step_frames=("step",))  # type: ignore[arg-type]


@dataclass
class Answering:
    """A pool that answers each task with what was prepared for it."""

    answers: dict[str, Any]
    asked: list[str] = field(default_factory=list)

    async def do(self, key: str, task: Any, *arguments: Any, say: Any = None) -> Any:
        self.asked.append(task.__name__)
        answer = self.answers.get(task.__name__)
        if task is tasks.complete and answer is not None:
            say(answer)
            say("note: nothing may be written here")
        return answer


def test_what_was_drawn_of_suspects_stays_until_another_diagnosis_is_kept():
    async def story() -> None:
        pool = Answering({})
        session = SessionState(Path("none"), pool)  # type: ignore[arg-type]
        for diagnosis, drawn, known in (
            ("a", "first", {}),
            ("a", "second", {"a": "first"}),
            ("b", "third", {}),
        ):
            pool.answers = {"look": looked(diagnosis)}
            assert session.start("Reading", tasks.look)
            await asyncio.gather(*session._runs)
            assert session.suspects.suspects == known
            pool.answers["complete"] = Drawn({drawn: "frame"}, {diagnosis: drawn})
            await session._complete()
            assert session.suspects.suspects == {diagnosis: drawn}
            assert drawn in session.frames
            assert session.notice == "Nothing may be written here."

    alone(story)


def test_the_diagnosis_of_an_earlier_model_is_there_again_when_it_is_gone_back_to():
    """A session keeps the last diagnosis only, and another worker may look at it than the one that made it."""

    async def story() -> None:
        pool = Answering({})
        session = SessionState(Path("none"), pool)  # type: ignore[arg-type]
        seen = []
        for asked, present, raw in (("a", "a", 1), ("b", "b", 1), ("b", "a", 1), ("b", "a", 2)):
            pool.answers = {"look": looked(asked, present=present, stamp=(raw, 0))}
            assert session.start("Reading", tasks.look)
            await asyncio.gather(*session._runs)
            assert session.view is not None
            assert session.view.diagnosis is not None
            seen.append(session.view.diagnosis.model.effects)
        assert seen == [["a"], ["b"], ["a"], ["b"]]  # the last one is of another recording

    alone(story)


def test_who_cancels_twice_leaves_no_dead_worker(monkeypatch):
    monkeypatch.setattr(worker, "Worker", Occupied)
    Occupied.gate = threading.Event()

    async def story() -> None:
        pool = worker.WorkerPool(Settings(), most=1)
        first, own = pool._workers[0], asyncio.create_task(pool.do("a", "long"))
        await asyncio.sleep(0.05)
        own.cancel()
        await asyncio.sleep(0)
        own.cancel()
        with pytest.raises(asyncio.CancelledError):
            await own
        assert pool._workers[0] is not first
        pool.end()

    alone(story)


def test_a_change_that_a_cancelled_worker_left_half_way_is_completed(monkeypatch, tmp_path):
    import numpy as np

    from daq import manifest
    from daq.recording import Channel, Recording
    from daq.session import Session, verify

    samples = np.sin(np.arange(64) / 5.0)[np.newaxis]
    recording = Recording(64.0, (Channel("u", "displacement", "m"),), samples, np.ones(64, dtype=bool))
    session = Session.create_imported(tmp_path / "s", recording, None)

    class Ended(Occupied):
        def do(self, task: str, arguments: tuple[Any, ...], say: worker.Say) -> str:
            with monkeypatch.context() as killed:
                killed.setattr(manifest, "_move", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
                with pytest.raises(KeyboardInterrupt):
                    session.write_results({"ladder.json": "new", "model.json": "new"})
            assert not verify(session.folder).ok
            raise worker.Ended

    monkeypatch.setattr(worker, "Worker", Ended)

    async def story() -> None:
        pool = worker.WorkerPool(Settings(), most=1)
        with pytest.raises(worker.Failed):
            await pool.do("a", "add", session.folder, "effect")
        pool.end()

    Occupied.gate = threading.Event()
    alone(story)
    assert verify(session.folder).ok
    assert (session.results / "ladder.json").read_text() == "new"


def test_a_session_that_is_ticked_beside_others_follows_its_new_name_and_goes_when_it_is_gone(tmp_path):
    state = AppState(Settings(), Answering({}), None, tmp_path)  # type: ignore[arg-type]
    folders = [tmp_path / name for name in ("one", "two", "three")]
    for folder in folders:
        folder.mkdir()
    first = state.session(folders[0])
    first.others = tuple(folders[1:])
    state.session(folders[1])
    state.moved(folders[1], place := folders[1].rename(tmp_path / "second"))
    assert first.others == (place, folders[2])
    assert list(state.sessions) == folders[:1]
    folders[2].rmdir()
    assert first.others == (place,)


def test_a_click_of_a_second_tab_that_is_dropped_is_told_and_stays_told():
    async def story() -> None:
        session = SessionState(Path("none"), Answering({"look": looked()}))  # type: ignore[arg-type]
        assert session.start("Adding cubic stiffness", tasks.look)
        version = session.version
        assert not session.start("Taking friction out", tasks.look)
        assert session.version > version  # every tab shows it
        await asyncio.gather(*session._runs)
        assert session.notice.startswith("Adding cubic stiffness is under way")

    alone(story)


@pytest.mark.parametrize(
    ("typed", "shown"),
    [
        ("mm was assumed (change it with --unit displacement=...)", "mm was assumed"),
        ("where letters are wrong, name another, as --encoding cp1250 (Central Europe)",
         "where letters are wrong, name another (Central Europe)"),
        ("name its encoding, as --encoding utf-16-le, or export it as CSV", "name its encoding, or export it as CSV"),
        ("use --column displacement='Position (mm)' or --resample; it ends", "use or; it ends"),
        ("no effect is called 'x'; see `station effects`, or write one", "no effect is called 'x'; write one"),
        ("u--v at -3 mm - or not", "u--v at -3 mm - or not"),
    ],
)  # fmt: skip
def test_the_page_names_no_option_of_a_command(typed, shown):
    assert on_the_page(typed) == shown


def test_progress_is_the_share_of_what_a_task_counts_and_none_where_it_counts_nothing():
    session = SessionState(Path("none"), Answering({}))  # type: ignore[arg-type]
    assert session.share_done is None
    session.running = "Trying every effect"
    for words, share in (
        ("fit 12 of 48", 0.25),
        ("drawing suspect 8 of 8", 1.0),
        ("judging whether one effect explains it, or several together", None),
    ):
        session.progress = words
        assert session.share_done == share
