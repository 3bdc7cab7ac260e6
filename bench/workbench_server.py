"""A workbench on two mysteries with a browser in front of it: what the measurement and the pictures have in common."""

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from playwright.sync_api import Browser, Page, sync_playwright

from daq.capture import CaptureSettings, capture
from daq.session_info import SessionInfo
from station.operations.simulated_board import simulated_board

ROOT = Path(__file__).resolve().parent.parent
SEEDS = (3, 12, 7)
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
VIRTUAL_CARD = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


@contextmanager
def workbench() -> Iterator[str]:
    """Record mysteries from the double, serve them, and give the address that was printed, with its token."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        for seed in SEEDS:
            info = SessionInfo(name=f"mystery_{seed}", mass_kg=21.36)
            wanted = CaptureSettings(check_clock=False, info=info)
            with simulated_board(
                seed, 0.0, "--truth", str(folder / "truth.json"), module="mocks.mystery"
            ) as port:
                capture(port, wanted, folder / "sessions" / f"mystery_{seed}")
        process = subprocess.Popen(
            [sys.executable, "-m", "station", "workbench", "--no-browser"],
            cwd=folder, env=os.environ | {"PYTHONPATH": str(ROOT)}, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        assert process.stderr is not None
        try:
            yield process.stderr.readline().split()[1]
        finally:
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=20)


def admitted(browser: Browser, printed: str, **options: Any) -> tuple[Page, str]:
    """Return a tab that has the token's cookie, and the address without the token; `options` are the tab's."""
    context = browser.new_context(**options)
    context.request.get(printed, max_redirects=0)
    return context.new_page(), printed.partition("/?")[0]


@contextmanager
def browser(*, webgl: bool = False) -> Iterator[Browser]:
    """Start the browser that is installed here.

    Rerun's viewer needs `webgl`, for which the processor plays a graphics card: that alone takes 0.5 s of it for each
    picture of the page, so that nothing is timed so.
    """
    program = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    if program is None:
        raise FileNotFoundError(f"no browser here; looked for {', '.join(BROWSERS)}")
    with sync_playwright() as play:
        started = play.chromium.launch(
            executable_path=program, args=["--no-sandbox", *(VIRTUAL_CARD if webgl else ())]
        )
        yield started
        started.close()
