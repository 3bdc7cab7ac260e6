"""The page: record on the left, where the model fails in the middle, what is missing beneath, the fall on the right."""

import json
import time
from collections.abc import Callable
from typing import Any

from nicegui import background_tasks, ui

from identify.formatting import plain_name
from station.operations import refining
from station.report.write import NAME
from station.workbench import tasks, telling, widgets
from station.workbench.capture_panel import CapturePanel, ScopePanel
from station.workbench.capture_run import CaptureRun
from station.workbench.cards_panel import CardsPanel
from station.workbench.guide_panel import GuidePanel
from station.workbench.others_menu import others_menu, validate_dialog
from station.workbench.parts import part
from station.workbench.session_menu import SessionMenu
from station.workbench.session_state import AppState, SessionState
from station.workbench.sessions_panel import SessionsPanel
from station.workbench.statements import says_of, switched_off
from station.workbench.view_models import Drawing
from station.workbench.waiting import BusyLine, TellingPanel

TICK_S = 0.05
SLOW_S = 0.4
"""Seconds after which a computation is shown to run."""

STORY, DETAILS, NUMBERS, RERUN = "Story", "Curves", "Identification", "3-D / Rerun"
PICTURES = {
    "map": "The force that the model lacks over displacement and velocity, before and after",
    "traces": "Measurement and model over time, and the residual with the noise",
}


class Page:
    """One browser tab."""

    def __init__(self, state: AppState, key: str | None, host: str) -> None:
        self._state, self._key, self._host = state, key, host
        folder = state.session_list.folder_of(key) if key else None
        self._session: SessionState | None = state.session(folder) if folder else None
        self._seen = -1
        ui.page_title(f"{key} · workbench" if key else "workbench")
        with ui.element("header").classes("bench-head"):
            self._build_header()
        with ui.element("div").classes("bench-columns").props("id=columns") as columns:
            columns.classes("" if key else "start")
            with ui.element("aside").classes("bench-column rail").props('id=rail aria-label="The bench"'):
                self._capture = CapturePanel(state, self._record, key)
                GuidePanel(state, self._capture)
                SessionsPanel(state, key)
            middle = ui.element("section").classes("bench-column story")
            with middle.props('aria-label="Measurement and model"'):
                self._build_middle()
            self._right = ui.element("aside").classes("bench-column fall").props('aria-label="The ladder"')
            if self._session is not None:
                with self._right:
                    self._ladder = widgets.html("contents", self._does)
        self._right.set_visibility(False)
        ui.run_javascript("bench.showTheme()")
        if self._session is not None:
            self._session.news.subscribe(self._tick)
            self._session.open()
        ui.timer(TICK_S, self._tick)

    def _build_header(self) -> None:
        turn = "Show or hide sessions and recording"
        rail = widgets.button(
            "Sessions", lambda: ui.run_javascript("bench.turnRail()"), turn, classes="rail-button"
        )
        rail.props("aria-controls=rail").set_visibility(self._key is not None)
        ui.link("Free-Decay Station", "/").classes("bench-title")
        widgets.label(self._key or "workbench", "bench-session")
        with ui.tabs().props("dense no-caps inline-label narrow-indicator") as self._head_tabs:
            for name in (STORY, DETAILS, NUMBERS, RERUN):
                ui.tab(name)
        self._head_tabs.classes("head-tabs").on_value_change(self._open_tab).set_visibility(False)
        if self._session is not None and self._key is not None:
            SessionMenu(self._state, self._session, self._key)
            with widgets.line().props("aria-live=polite"):
                self._report = TellingPanel(self._session, telling.report, "gathering")
                if self._state.session_list.result_of(self._key, NAME):
                    self._report.show(telling.way_to_report(self._key))
            widgets.button("Report", self._write_report, "Write the report of this session")
        widgets.button("", self._turn_theme, "Switch between light and dark").props("id=theme")

    def _build_middle(self) -> None:
        self._busy = BusyLine(lambda: self._session.cancel() if self._session else None, "card tight busybar")
        with widgets.line("card tight notice") as self._notice:
            self._said = widgets.label("", "grow wrap")
            widgets.button(
                "Close", lambda: self._session.say("") if self._session else None, "Close the message"
            )
        self._notice.set_visibility(False)
        self._scope = ScopePanel()
        does = {
            "solve": lambda _: self._capture.solve_mystery(),
            "examples": lambda _: ui.run_javascript("bench.toExamples()"),
        }
        with ui.element("div").classes("empty grow") as self._empty:
            self._words = widgets.html("contents", does)
            if self._session is not None:
                self._recorded = TellingPanel(self._session, telling.recorded, "Drawing what was recorded")
        self._tabs = ui.element("div").classes("story-tabs")
        if self._session is not None:
            with self._tabs:
                self._build_tabs(self._session)
        self._tabs.set_visibility(False)
        self._say_why_empty()

    def _build_tabs(self, session: SessionState) -> None:
        sessions, self._feed = self._state.session_list, StageFeed(session)
        self._does = self._actions(session, validate_dialog(session, sessions).open)
        with ui.tab_panels(self._head_tabs, value=STORY, animated=False, keep_alive=True).classes("panels"):
            with ui.tab_panel(STORY).classes("story-panel"):
                widgets.html("contents").content = part("statement")
                with ui.element("section").classes("stage").props('aria-label="Where the model fails"'):
                    with widgets.line("small faint"):
                        widgets.label("Force that the model lacks; grey: none, or within the noise", "grow")
                        widgets.html().content = part("channel")
                    for name, label in PICTURES.items():
                        widgets.chart(name, label, f"plot-{name}")
                self._cards = CardsPanel(session, sessions, self._does)
            with ui.tab_panel(DETAILS):
                self._details = TellingPanel(
                    session, telling.compared, "Comparing the model with the measurement"
                )
            with ui.tab_panel(NUMBERS):
                with widgets.line():
                    widgets.head("Stiffness and damping by two methods")
                    others_menu(session, sessions, self._open_tab)
                doing = "Identifying: envelope and frequency, and the restoring force surface"
                self._identified = TellingPanel(session, telling.identified, doing)
            with ui.tab_panel(RERUN):
                self._viewer = TellingPanel(session, telling.viewer, "Writing the viewer's recording")

    def _actions(self, session: SessionState, validate: Callable[[], Any]) -> dict[str, Callable[[str], Any]]:
        """Name what a click on an element of `parts.html` does, by the name that the element carries."""

        return {
            "add": session.add,
            "diagnose": lambda _: session.diagnose(),
            "refine": lambda _: session.start("Refining", tasks.refine),
            "reveal": lambda _: session.start("Asking the simulated board", tasks.reveal),
            "go": lambda place: session.change(f"Going to step {place}", refining.go_to, int(place)),
            "undo": lambda _: session.undo(),
            "remove": lambda name: session.change(f"Removing {plain_name(name)}", refining.remove, name),
            "report": lambda _: self._write_report(),
            "validate": lambda _: validate(),
            "prune": lambda _: session.change("Trying to do without each effect", refining.drop_needless),
        }

    async def _open_tab(self) -> None:
        """Ask for what the chosen tab shows; the viewer needs all of a small screen's width."""
        chosen = self._head_tabs.value
        if self._session is None or self._session.view is None:
            return
        self._right.set_visibility(chosen != RERUN)
        if chosen == NUMBERS:
            await self._identified.open(self._session.others)
        elif chosen != STORY:
            with self._tabs:
                dark = await widgets.is_dark()
                if chosen == DETAILS:
                    await self._details.open(dark)
                else:
                    await self._viewer.open(self._state.temporary, self._host, dark)

    async def _write_report(self) -> None:
        if self._session is not None:
            await self._report.open(anew=True)

    def _turn_theme(self) -> None:
        ui.run_javascript("bench.turnTheme()")
        self._seen = -1

    def _record(self, capture: CaptureRun) -> None:
        """Give the middle to the scope; the session of the recording is opened when it is sealed."""
        for place in (self._empty, self._tabs, self._right):
            place.set_visibility(False)
        self._scope.follow(capture)
        self._seen = -1

    def _tick(self) -> None:
        session = self._session
        if session is None:
            self._empty.set_visibility(self._scope.run is None)
            return
        self._show_busy(session)
        if session.version != self._seen and self._scope.run is None:
            self._seen = session.version
            self._show(session)

    def _show_busy(self, session: SessionState) -> None:
        """Show what runs. The loop takes no clicks while it computes; what it shows stays readable."""
        words, seconds = "", time.monotonic() - session.since
        if session.running and seconds > SLOW_S:
            doing = session.progress or "waiting for a free worker"
            words = f"{session.running}: {doing} ({seconds:.0f} s)"
        self._busy.show(words, session.share_done)
        for place in (self._right, self._tabs):
            if bool(place.props.get("inert")) != bool(words):
                place.props.set_bool("inert", bool(words))

    def _say_why_empty(self) -> None:
        """Say how it stands where there is nothing to show of a session, or no session."""
        problem = "" if self._session is None else self._session.problem
        self._words.content = part("empty", self._key, self._session is not None, problem)
        if problem:
            background_tasks.create(self._draw())

    async def _draw(self) -> None:
        with self._empty:
            await self._recorded.open(await widgets.is_dark())

    def _show(self, session: SessionState) -> None:
        view = session.view
        self._said.text = session.notice
        self._notice.set_visibility(bool(session.notice))
        for place in (self._head_tabs, self._tabs):
            place.set_visibility(view is not None)
        self._empty.set_visibility(view is None)
        if view is None:
            self._say_why_empty()
            return
        self._right.set_visibility(self._head_tabs.value != RERUN)
        self._ladder.content = part("fall", view, bool(session.earlier), switched_off(view.ladder))
        self._cards.show(view)
        if self._head_tabs.value in (DETAILS, NUMBERS) and not session.running:
            background_tasks.create(self._open_tab())
        self._feed.send()


class StageFeed:
    """Sends one tab what its pictures need: each frame once, with its changes."""

    def __init__(self, session: SessionState) -> None:
        self._session = session
        self._stage: Drawing = {}
        self._sent: set[str] = set()

    def send(self) -> None:
        """Send what is new since the last time."""
        session, view = self._session, self._session.view
        if view is None or not view.stage:
            return
        document = view.diagnosis if view.about_present and not view.at_floor else None
        present = view.ladder.top.effects
        suspects = {e: name for e, name in session.suspects.suspects.items() if e not in present}
        shown = session.frames.get(view.step_frames[view.ladder.present], {})
        says = session.suspects.says | says_of(view, shown.get("summary", ""))
        news: dict[str, Any] = {
            "steps": list(view.step_frames),
            "present": view.ladder.present,
            "suspects": suspects,
            "best": document.named[0] if document is not None and document.named else None,
            "says": says,
            "names": {name: plain_name(name) for name in says},
        }
        if self._stage != view.stage:
            news["stage"] = view.stage
            self._sent.clear()
        self._stage = view.stage
        wanted = {*view.step_frames, *suspects.values()} - self._sent
        news["frames"] = {name: frame for name, frame in session.frames.items() if name in wanted}
        self._sent.update(news["frames"])
        ui.run_javascript(f"bench.receive({json.dumps(news)})")
