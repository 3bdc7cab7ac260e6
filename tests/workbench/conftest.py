"""A workbench as a process of its own on sessions with hidden effects, and a real browser to walk through it."""

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from daq.capture import CaptureSettings, capture
from daq.session_info import SessionInfo
from mocks import mystery
from mocks.in_process import running

ROOT = Path(__file__).parents[2]


HIDDEN = {"mystery_7": "stribeck_friction", "mystery_12": "quadratic_damping"}
"""What `mocks.mystery` hides under these numbers; read from its envelope when the sessions are made."""

BROWSERS = ("chromium", "chromium-browser", "google-chrome")


@dataclass(frozen=True)
class Bench:
    """A running workbench: the address that it printed, the same without its token, and its folder."""

    printed: str
    address: str
    folder: Path
    mysteries: Callable[[], Path]

    def fresh(self, hidden: str, called: str) -> str:
        """Put a copy of a mystery into the folder of sessions, untouched by other tests; return its address."""
        place = self.folder / "sessions" / called
        shutil.rmtree(place, ignore_errors=True)  # of a test that is begun anew
        shutil.copytree(self.mysteries() / hidden, place)
        return self.session(called)

    def session(self, name: str) -> str:
        return f"{self.address}/?session={name}"

    def results(self, name: str) -> Path:
        return self.folder / "sessions" / name / "results"


def mystery_board(seed: int, envelope: Path) -> AbstractContextManager[str]:
    """Serve what `python -m mocks.mystery` serves under this seed, from a thread; the truth goes into the envelope."""
    return running(
        "--tcp", "0", "--seed", str(seed), "--speed", "0", "--truth", str(envelope), "--hide", mystery.draw(seed)
    )  # fmt: skip


@pytest.fixture(scope="session")
def mysteries(tmp_path_factory: pytest.TempPathFactory) -> Callable[[], Path]:
    """Record one release of each mystery from the double, when a test first asks for them."""

    @cache
    def record() -> Path:
        made = tmp_path_factory.mktemp("mysteries")
        with TemporaryDirectory() as aside:
            for name, hidden in HIDDEN.items():
                envelope = Path(aside) / f"{name}.json"
                info = SessionInfo(name=name, mass_kg=21.36, specimen=name.replace("_", " "))
                with mystery_board(int(name.rpartition("_")[2]), envelope) as port:
                    capture(port, CaptureSettings(check_clock=False, info=info), made / name)
                assert f'"hidden": "{hidden}"' in envelope.read_text()
        return made

    return record


@pytest.fixture(scope="session")
def bench(mysteries: Callable[[], Path], tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    """Start a workbench on an empty folder; it must end at Ctrl-C without a complaint."""
    folder = tmp_path_factory.mktemp("bench")
    (folder / "sessions").mkdir()
    command = [sys.executable, "-m", "station", "workbench", "--no-browser"]
    user = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST")}
    environment = user | {
        "PYTHONUNBUFFERED": "1",
        "PYTHONPATH": str(ROOT),
    }  # NiceGUI asks whether it is tested
    process = subprocess.Popen(command, cwd=folder, env=environment, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    said = process.stderr.readline()
    assert said.startswith("workbench: http://127.0.0.1:"), said + process.stderr.read()
    try:
        printed = said.split()[1]
        yield Bench(printed, printed.partition("/?")[0], folder, mysteries)
    finally:
        process.send_signal(signal.SIGINT)
        rest = process.communicate(timeout=20)[1]
        assert "Traceback" not in rest, rest
        assert "nicegui" not in rest, rest


@pytest.fixture(scope="session")
def browser() -> Iterator[object]:
    """Start a browser that is installed here; skip where there is none."""
    program = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    if program is None:
        pytest.skip(f"no browser is installed here (looked for {', '.join(BROWSERS)})")
    driver = pytest.importorskip("playwright.sync_api", reason="playwright is not installed here")
    with driver.sync_playwright() as play:
        started = play.chromium.launch(executable_path=program, args=["--no-sandbox"])
        yield started
        started.close()


class Visit:
    """A tab, and everything that it asked for."""

    def __init__(self, page, asked: list[str], complaints: list[str]) -> None:
        self.page, self.asked, self.complaints = page, asked, complaints


@pytest.fixture
def visit(browser, bench: Bench) -> Iterator[Visit]:
    """Open a tab whose requests are watched: none may leave this machine, and no script may fail."""
    context = browser.new_context(viewport={"width": 1280, "height": 720})
    asked: list[str] = []
    complaints: list[str] = []
    context.on("request", lambda request: asked.append(request.url))
    context.on("weberror", lambda error: complaints.append(str(error.error)))
    context.on("dialog", lambda dialog: complaints.append(f"dialog: {dialog.message}"))
    context.request.get(bench.printed, max_redirects=0)  # the token's cookie
    page = context.new_page()
    page.set_default_timeout(90_000)  # no test asserts a time: a busy computer is only slow
    page.on("websocket", lambda socket: asked.append(socket.url))
    yield Visit(page, asked, complaints)
    context.close()
    here = bench.address.removeprefix("http://")
    outside = [
        url for url in asked if not url.startswith((f"http://{here}/", f"ws://{here}/", "data:", "blob:"))
    ]
    assert not outside
    assert not complaints
