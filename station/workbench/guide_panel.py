"""A guided test on the page: limits once, then what to release and why, and odds that move from release to release."""

from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, replace

from nicegui import ui

from daq.capture import CaptureObserver, CaptureSettings
from identify.diagnosis.guidance import Guidance
from identify.planning.next_release import Limits
from station.exits import UsageProblem
from station.operations.guiding import RIG, SIMULATED, GuidedTest, guide, limits_of
from station.operations.new_session import new_folder
from station.report.write import finish_guided
from station.results.diagnosis_document import DiagnosisDocument, HypothesisDocument
from station.results.guide_document import TurnDocument
from station.text.diagnosis_text import headline
from station.text.guide_text import ENDINGS, SHOWN, gave, odds_of, to_do
from station.workbench import widgets
from station.workbench.capture_panel import CapturePanel
from station.workbench.capture_run import CaptureRun, mystery
from station.workbench.parts import part
from station.workbench.session_state import AppState

TICK_S = 0.2


@dataclass(frozen=True)
class GuideNow:
    """Where a guided test stands: what to do, why, and the last verdict.

    `gave` is the evidence that the last release gave, beside what was expected of it; `hypotheses` have their odds after it,
    `before` those before it, by title.
    """

    to_do: str = ""
    why: str = ""
    verdict: str = ""
    gave: str = ""
    hypotheses: list[HypothesisDocument] = field(default_factory=list)
    before: Mapping[str, float] = field(default_factory=dict)


class GuideRun(CaptureRun):
    """The captures of a guided test, one after another; it is its own watcher, and `guide` says where it stands."""

    def __init__(self, board: AbstractContextManager[str], test: GuidedTest) -> None:
        self.guide, self._test = GuideNow(), test
        self.observer: CaptureObserver = self
        super().__init__(board, test.capture, test.folder)

    def asks(self, number: int, told: Guidance) -> None:
        """Note what to release, and why."""
        assert told.experiment is not None
        duration = self._test.capture.duration_s * told.experiment.longer
        self._settings = replace(self._test.capture, duration_s=duration)
        self.guide = replace(self.guide, to_do=f"Release {number}: {to_do(told)}", why=told.words)

    def provisional(self, answer: str) -> None:
        """Note a first answer."""
        self.guide = replace(self.guide, verdict=f"So far: {answer}")

    def judged(self, turn: TurnDocument, document: DiagnosisDocument | None) -> None:
        """Note the verdict, the odds, and what the release gave."""
        if document is None:
            self.guide = replace(self.guide, verdict=f"No result: {turn.problem}", gave="")
            return
        self.guide = replace(
            self.guide,
            verdict=headline(document),
            gave=gave(turn),
            hypotheses=turn.hypotheses[:SHOWN],
            before=odds_of(self.guide.hypotheses),
        )

    def _record(self, port: str) -> None:
        test = replace(self._test, port=port)
        document = guide(test, self, lambda: self._ended)
        self.now = replace(self.now, sentence="writing the report", detail="")
        document = finish_guided(test, document)
        last = f"{ENDINGS[document.state][0]}. {document.words}"
        self.guide = replace(self.guide, to_do=last, why=f"All of it: {document.folder}")


class GuidePanel:
    """What begins a guided test and shows how it goes on; `capture` has the port, and records."""

    def __init__(self, state: AppState, capture: CapturePanel) -> None:
        self._state, self._capture = state, capture
        self._shown: GuideNow | None = None
        with ui.expansion("Guided test").props("dense").classes("card"):
            with ui.element("div") as self._form:
                with widgets.line():
                    self._low = widgets.number("Least, mm", 2.0)
                    self._high = widgets.number("Largest, mm", 25.0)
                self._alone = ui.checkbox("The rig releases itself")
                widgets.button("Begin", self._begin, "Begin the guided test", strong=True, classes="wide")
                widgets.button("No board? On a simulated rig", self._simulate, classes="wide")
            self._place = widgets.html().props("aria-live=polite")
            self._stop = widgets.button(
                "Stop", lambda: state.capturing.cancel() if state.capturing else None, "Stop the guided test"
            )
        ui.timer(TICK_S, self._tick)

    def _begin(self) -> None:
        alone = bool(self._alone.value)
        try:
            limits = limits_of(f"{self._low.value}mm,{self._high.value}mm", alone)
        except UsageProblem:
            ui.notify("give two amplitudes above 0, the smaller one first", type="warning")
            return
        if asked := self._capture.asked():
            port, wanted = asked
            self._start(nullcontext(port), wanted, limits, alone)

    def _simulate(self) -> None:
        _, board, wanted = mystery(self._state.settings, *RIG)
        self._start(board, wanted, SIMULATED, True)

    def _start(
        self, board: AbstractContextManager[str], wanted: CaptureSettings, limits: Limits, alone: bool
    ) -> None:
        settings = self._state.settings
        test = GuidedTest("", wanted, limits, new_folder(settings.sessions, "guide"), settings, alone)
        self._capture.begin(lambda: GuideRun(board, test))

    def _tick(self) -> None:
        run = self._state.capturing
        self._form.set_visibility(run is None or run.now.finished)
        self._stop.set_visibility(isinstance(run, GuideRun) and not run.now.finished)
        if not isinstance(run, GuideRun) or run.guide is self._shown:
            return
        now = self._shown = run.guide
        said = [
            (now.to_do, "strong"),
            (now.why, "small"),
            (now.verdict, "strong"),
            (f"It gave {now.gave}." if now.gave else "", "small"),
        ]
        self._place.content = part("lines", said) + part("odds", now.hypotheses, now.before)
