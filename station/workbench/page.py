"""The page: bench on the left, measurement and model in the middle, the loop on the right."""

import time

from nicegui import ui

from station.workbench import widgets
from station.workbench.app_state import AppState
from station.workbench.capture_panel import CapturePanel
from station.workbench.loop_panel import LoopPanel
from station.workbench.middle_panel import MiddlePanel
from station.workbench.report_button import ReportButton
from station.workbench.rerun_tab import RerunTab
from station.workbench.session_state import SessionState
from station.workbench.sessions_panel import SessionsPanel
from station.workbench.theme import theme

TICK_S = 0.05
SLOW_S = 0.4


class Page:
    """One browser tab."""

    def __init__(self, state: AppState, key: str | None, host: str) -> None:
        self._state, self._key, self._host = state, key, host
        folder = state.session_list.folder_of(key) if key else None
        self._session: SessionState | None = state.sessions.at(folder) if folder else None
        self._seen = -1
        self._shown: object = None
        self._loop_shown: object = None
        self._dark = False

    def build(self) -> None:
        """Make the page."""
        ui.page_title(f"{self._key} · workbench" if self._key else "workbench")
        self._mode = ui.dark_mode(None)
        self._header()
        with ui.element("div").classes("bench-columns"):
            with ui.element("aside").classes("bench-column").props('aria-label="The bench"'):
                CapturePanel(self._state).build()
                SessionsPanel(self._state.session_list, self._state.workers, self._key).build()
            with ui.element("div").classes("bench-column").props('aria-label="Measurement and model"'):
                self._build_middle()
            with ui.element("aside").classes("bench-column loop").props('aria-label="The loop"'):
                self._build_right()
        ui.timer(0.05, self._begin, once=True)

    def _header(self) -> None:
        with ui.element("header").classes("bench-head"):
            ui.link("Free-Decay Station", "/").classes("bench-title").style(
                "color:inherit;text-decoration:none"
            )
            widgets.label(self._key or "workbench", "bench-session")
            if self._session is not None and self._key is not None:
                ReportButton(self._state, self._session, self._key).build()
            self._theme_button = widgets.button("Dark", self._turn_theme, "Switch between light and dark")

    def _build_middle(self) -> None:
        self._busy = ui.element("section").classes("card tight busybar").props("role=status aria-live=polite")
        with self._busy, widgets.line():
            ui.spinner(size="18px")
            self._busy_label = widgets.label("", "grow")
            widgets.button("Cancel", lambda: self._session.cancel() if self._session else None)
        self._busy.set_visibility(False)
        self._notice = widgets.card("tight notice")
        with self._notice, widgets.line():
            self._notice_label = widgets.label("", "grow wrap")
            widgets.button("Close", self._close_notice, "Close the message")
        self._notice.set_visibility(False)
        self._empty = ui.element("div").classes("empty grow")
        self._pictures = ui.element("div").style("display:flex;flex-direction:column;gap:8px")
        self._middle = MiddlePanel()
        with self._pictures:
            self._build_tabs()
        self._pictures.set_visibility(False)
        self._say_empty()

    def _build_tabs(self) -> None:
        with ui.tabs().props("dense align=left no-caps inline-label narrow-indicator") as tabs:
            charts = ui.tab("Measurement and model")
            rerun = ui.tab("3-D / Rerun")
        with ui.tab_panels(tabs, value=charts, animated=False, keep_alive=True):
            with ui.tab_panel(charts):
                self._middle.build()
            with ui.tab_panel(rerun):
                if self._session is not None and self._key is not None:
                    viewer = RerunTab(self._state, self._session, self._key, self._host)
                    viewer.build()
                    tabs.on_value_change(lambda e: viewer.open() if e.value == "3-D / Rerun" else None)

    def _say_empty(self) -> None:
        self._empty.clear()
        with self._empty:
            if self._session is not None and self._session.problem:
                widgets.label("This recording does not allow an analysis", "strong")
                widgets.label(self._session.problem, "wrap").style("max-width:520px")
                widgets.label("What was recorded is kept. Choose another session, or record again.", "small")
            elif self._session is not None:
                ui.spinner(size="32px")
                widgets.label("The session is read, and the usual model fitted to it.")
            elif self._key:
                widgets.label(f"There is no session called {self._key}", "strong wrap")
                widgets.label("Choose one on the left.")
            else:
                widgets.label("Choose a session on the left,", "strong")
                widgets.label("drop a file there, or capture a release from a board.")

    def _build_right(self) -> None:
        self._loop: LoopPanel | None = None
        self._right = ui.element("div").style("display:flex;flex-direction:column;height:100%")
        with self._right:
            if self._session is not None:
                self._loop = LoopPanel(self._session)
                self._loop.build()
            else:
                with widgets.card(), ui.element("div").classes("empty"):
                    widgets.label("Here the loop is closed:", "strong")
                    widgets.label("diagnose what the model lacks, add it, and watch the error fall.", "small")
        if self._session is not None:
            self._right.set_visibility(False)

    async def _begin(self) -> None:
        self._dark = bool(await ui.run_javascript("bench.dark()", timeout=5.0))
        self._set_theme()
        if self._session is not None:
            self._session.open()
            ui.timer(TICK_S, self._tick)

    def _turn_theme(self) -> None:
        self._dark = not self._dark
        ui.run_javascript(f"bench.keepTheme({'true' if self._dark else 'false'})")
        self._set_theme()
        self._shown = None
        self._seen = -1

    def _set_theme(self) -> None:
        self._mode.value = self._dark
        self._theme_button.text = "Light" if self._dark else "Dark"

    def _close_notice(self) -> None:
        if self._session is not None:
            self._session.notice = ""
            self._session.version += 1

    def _hold_still(self, still: bool) -> None:
        """Take no clicks on the loop while it computes; what it shows stays readable."""
        if bool(self._right.props.get("inert")) != still:
            self._right.props(add="inert") if still else self._right.props(remove="inert")

    def _tick(self) -> None:
        session = self._session
        if session is None:
            return
        running = session.running
        if running is not None:
            seconds = time.monotonic() - running.since
            self._busy_label.text = (
                f"{running.title}: {session.progress or 'waiting for a free worker'} ({seconds:.0f} s)"
            )
            slow = running.long or seconds > SLOW_S
            self._busy.set_visibility(slow)
            self._hold_still(slow)
        else:
            self._busy.set_visibility(False)
            self._hold_still(False)
        if session.version == self._seen:
            return
        self._seen = session.version
        self._notice_label.text = session.notice
        self._notice.set_visibility(bool(session.notice))
        if session.view is None:
            self._say_empty()
            return
        self._empty.set_visibility(False)
        self._pictures.set_visibility(True)
        self._right.set_visibility(True)
        colours = theme(self._dark)
        if self._shown is not session.view.picture:
            shown = session.view
            self._middle.show(shown.picture, shown.curves, colours, shown.ladder.top.error.chi2)
            self._shown = session.view.picture
        loop = (session.view, session.force_maps, session.notice, self._dark)
        if self._loop is not None and loop != self._loop_shown:
            self._loop.show(session.view, colours)
            self._loop_shown = loop
