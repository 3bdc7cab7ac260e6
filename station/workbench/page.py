"""The page: record on the left, where the model fails in the middle, what is missing beneath, the fall on the right."""

from functools import partial

from nicegui import background_tasks, ui

from station.workbench import widgets
from station.workbench.app_state import AppState
from station.workbench.busy_bar import BusyBar
from station.workbench.capture_panel import CapturePanel
from station.workbench.capture_run import CaptureRun
from station.workbench.cards_panel import CardsPanel
from station.workbench.empty_middle import say_empty
from station.workbench.floor_card import FloorCard
from station.workbench.guide_panel import GuidePanel
from station.workbench.identification_panel import IdentificationPanel
from station.workbench.ladder_panel import LadderPanel
from station.workbench.report_button import ReportButton
from station.workbench.rerun_tab import RerunTab
from station.workbench.scope_panel import ScopePanel
from station.workbench.session_menu import SessionMenu
from station.workbench.session_state import SessionState
from station.workbench.sessions_panel import SessionsPanel
from station.workbench.stage_feed import StageFeed
from station.workbench.story_panel import StoryPanel
from station.workbench.telling_panel import TellingPanel
from station.workbench.validate_dialog import ValidateDialog
from station.workbench.widgets import run

TICK_S = 0.05
STORY, DETAILS, NUMBERS, RERUN = "Story", "Curves", "Identification", "3-D / Rerun"


class Page:
    """One browser tab."""

    def __init__(self, state: AppState, key: str | None, host: str, step: int | None = None) -> None:
        self._state, self._key, self._host, self._step = state, key, host, step
        folder = state.session_list.folder_of(key) if key else None
        self._session: SessionState | None = state.sessions.at(folder) if folder else None
        self._seen = -1
        self._dark = False

    def build(self) -> None:
        """Make the page."""
        ui.page_title(f"{self._key} · workbench" if self._key else "workbench")
        self._mode = ui.dark_mode(None)
        self._header()
        with ui.element("div").classes("bench-columns").props("id=columns") as columns:
            if self._key is None:
                columns.classes("start")
            with ui.element("aside").classes("bench-column rail").props('id=rail aria-label="The bench"'):
                self._capture = CapturePanel(self._state, self._record, self._key)
                self._capture.build()
                GuidePanel(self._state.settings, self._capture.busy).build()
                SessionsPanel(self._state, self._key).build()
            with (
                ui.element("section")
                .classes("bench-column story")
                .props('aria-label="Measurement and model"')
            ):
                self._build_middle()
            with (
                ui.element("aside")
                .classes("bench-column fall")
                .props('aria-label="The ladder"') as self._right
            ):
                if self._session is not None:
                    validation = ValidateDialog(self._session, self._state.session_list)
                    validation.build()
                    floor = FloorCard(
                        lambda: self._report.write() if self._report is not None else None,
                        validation.open,
                        partial(self._session.start, "Trying to do without each effect", "prune", long=True),
                    )
                    self._ladder = LadderPanel(self._session, floor)
                    self._ladder.build()
        self._right.set_visibility(False)
        ui.timer(0.05, self._begin, once=True)

    def _header(self) -> None:
        with ui.element("header").classes("bench-head"):
            rail = widgets.button(
                "Sessions", lambda: run("bench.turnRail()"), "Show or hide sessions and recording"
            )
            rail.classes("rail-button").props("aria-controls=rail")
            rail.set_visibility(self._key is not None)
            ui.link("Free-Decay Station", "/").classes("bench-title").style(
                "color:inherit;text-decoration:none"
            )
            widgets.label(self._key or "workbench", "bench-session")
            self._build_tabs()
            self._report: ReportButton | None = None
            if self._session is not None and self._key is not None:
                SessionMenu(self._state, self._session, self._key).build()
                self._report = ReportButton(self._session, self._key)
                self._report.build()
            self._theme_button = widgets.button("Dark", self._turn_theme, "Switch between light and dark")

    def _build_middle(self) -> None:
        self._busy = BusyBar()
        self._busy.build(lambda: self._session.cancel() if self._session else None)
        self._notice = widgets.card("tight notice")
        with self._notice, widgets.line():
            self._said = widgets.label("", "grow wrap")
            widgets.button("Close", self._close_notice, "Close the message")
        self._notice.set_visibility(False)
        self._scope = ScopePanel()
        self._scope.build()
        self._empty = ui.element("div").classes("empty grow")
        self._tabs = ui.element("div").classes("story-tabs")
        if self._session is not None:
            with self._tabs:
                self._build_panels(self._session)
        self._tabs.set_visibility(False)
        self._say_empty()

    def _build_tabs(self) -> None:
        with (
            ui.tabs()
            .props("dense no-caps inline-label narrow-indicator")
            .classes("head-tabs") as self._head_tabs
        ):
            for name in (STORY, DETAILS, NUMBERS, RERUN):
                ui.tab(name)
        self._head_tabs.set_visibility(False)

    def _build_panels(self, session: SessionState) -> None:
        self._story, self._details, self._cards = (
            StoryPanel(),
            TellingPanel(session, "compared", "Comparing the model with the measurement"),
            CardsPanel(session, self._state.session_list),
        )
        self._identified = IdentificationPanel(session, self._state.session_list)
        self._feed = StageFeed(session)
        with ui.tab_panels(self._head_tabs, value=STORY, animated=False, keep_alive=True).classes("panels"):
            with ui.tab_panel(STORY).classes("story-panel"):
                self._story.build()
                self._cards.build()
            with ui.tab_panel(DETAILS):
                self._details.build()
            with ui.tab_panel(NUMBERS):
                self._identified.build()
            with ui.tab_panel(RERUN):
                if self._key is not None:
                    viewer = RerunTab(self._state, session, self._key, self._host, lambda: self._dark)
                    viewer.build()
                    opens = {RERUN: viewer.open, NUMBERS: self._identified.open, DETAILS: self._show_details}
                    self._head_tabs.on_value_change(lambda e: opens[e.value]() if e.value in opens else None)
                    # the viewer needs all of a small screen's width
                    self._head_tabs.on_value_change(lambda e: self._right.set_visibility(e.value != RERUN))

    async def _show_details(self) -> None:
        await self._details.open(self._dark)

    def _say_empty(self) -> None:
        say_empty(self._empty, self._session, self._key, self._capture.solve_mystery, self._dark)

    async def _begin(self) -> None:
        try:
            self._dark = bool(await ui.run_javascript("bench.dark()", timeout=20.0))
        except TimeoutError:  # the tab was closed before it had read the page
            return
        self._set_theme()
        if self._session is not None:
            self._session.news.subscribe(self._tick)
            self._session.open()
        ui.timer(TICK_S, self._tick)

    def _turn_theme(self) -> None:
        self._dark = not self._dark
        run(f"bench.keepTheme({'true' if self._dark else 'false'})")
        self._set_theme()
        run("bench.redraw()")
        self._seen = -1

    def _set_theme(self) -> None:
        self._mode.value = self._dark
        self._theme_button.text = "Light" if self._dark else "Dark"

    def _record(self, capture: CaptureRun) -> None:
        """Give the middle to the scope; the session of the recording is opened when it is sealed."""
        self._empty.set_visibility(False)
        self._tabs.set_visibility(False)
        self._right.set_visibility(False)
        self._scope.follow(capture)
        self._seen = -1

    def _close_notice(self) -> None:
        if self._session is not None:
            self._session.notice = ""
            self._session.changed()

    def _hold_still(self, still: bool) -> None:
        """Take no clicks on the loop while it computes; what it shows stays readable."""
        for place in (self._right, self._tabs):
            if bool(place.props.get("inert")) != still:
                place.props(add="inert") if still else place.props(remove="inert")

    def _tick(self) -> None:
        session = self._session
        if session is None:
            if self._seen == -1 and not self._scope.visible:
                self._seen = 0
                self._empty.set_visibility(True)
            return
        self._hold_still(self._busy.show(session))
        if session.version == self._seen or self._scope.visible:
            return
        self._seen = session.version
        self._show(session)

    def _show(self, session: SessionState) -> None:
        self._said.text = session.notice
        self._notice.set_visibility(bool(session.notice))
        self._head_tabs.set_visibility(session.view is not None)
        if session.view is None:
            self._empty.set_visibility(True)
            self._say_empty()
            return
        self._empty.set_visibility(False)
        self._tabs.set_visibility(True)
        self._right.set_visibility(self._head_tabs.value != RERUN)
        view = session.view
        if view.stage is not None:
            self._story.show(view.stage)
        self._ladder.show(view)
        self._cards.show(view)
        if self._head_tabs.value == DETAILS and not session.busy:
            background_tasks.create(self._show_details())
        if self._head_tabs.value == NUMBERS:
            background_tasks.create(self._identified.open())
        self._feed.send()
        if self._step is not None and 0 <= self._step < len(view.ladder.steps) and self._feed.whole:
            run(f"bench.filmTo({self._step})")
            self._step = None
