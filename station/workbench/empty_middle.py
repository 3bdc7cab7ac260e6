"""The middle of the page without a result: a welcome, a wait, or why a record allows no analysis."""

from collections.abc import Callable

from nicegui import ui

from station.workbench import telling, widgets
from station.workbench.session_state import SessionState
from station.workbench.telling_panel import TellingPanel
from station.workbench.widgets import run


def say_empty(session: SessionState | None, key: str | None, solve_mystery: Callable[[], None]) -> None:
    """Fill the place."""
    if session is not None and session.problem:
        widgets.label("This recording does not allow an analysis", "strong")
        widgets.label(session.problem, "wrap narrow")
        widgets.label("What was recorded is kept. Choose another session, or record again.", "small")
        recorded = TellingPanel(session, telling.recorded, "Drawing what was recorded")

        async def show() -> None:
            await recorded.open(await widgets.is_dark())

        ui.timer(0.05, show, once=True)
    elif session is not None:
        widgets.spinner(32)
        widgets.label("The session is read, and the usual model fitted to it.")
    elif key:
        widgets.label(f"There is no session called {key}", "strong wrap")
        widgets.label("Choose one on the left.")
    else:
        widgets.label(
            "Where does the usual model of a vibration fail, and which effect does it lack?", "welcome"
        )
        widgets.label(
            "Record a release from a board (arm it, then let the mass go), drop a file, or choose a session. Then: see "
            "where the model fails, point at what it may lack, add it, and watch the error fall to the noise.",
            "wrap narrow",
        )
        with widgets.line():
            widgets.button("No board? Solve a mystery", solve_mystery, strong=True)
            widgets.button("Open an example", lambda: run("bench.toExamples()"))
