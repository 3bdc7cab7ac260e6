"""A guided test on the page: limits once, then what to release and why, and odds that move from release to release."""

import threading
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, replace

import numpy as np
from nicegui import ui

from daq.capture import CaptureObserver, CaptureSettings
from identify.diagnosis.guidance import Guidance
from identify.planning.next_release import Limits
from station.exits import sentence_of
from station.operations.guiding import RIG, SIMULATED, GuidedTest, guide
from station.operations.new_session import capture_settings, new_folder, session_info
from station.report.write import finish_guided
from station.results.diagnosis_document import DiagnosisDocument, HypothesisDocument
from station.results.guide_document import TurnDocument
from station.settings import Settings
from station.text.capture_progress import STATES
from station.text.diagnosis_text import headline
from station.text.guide_text import ENDINGS, gave, odds_of, to_do
from station.text.layout import sentence
from station.workbench import widgets
from station.workbench.capture_run import mystery
from station.workbench.parts import part

TICK_S = 0.2
_SHOWN = 5


@dataclass(frozen=True)
class GuideNow:
    """Where a guided test stands: what to do, why, how the capture goes, and the last verdict.

    `gave` is the evidence that the last release gave, beside what was expected of it; `hypotheses` have their odds after it,
    `before` those before it, by title.
    """

    to_do: str = ""
    why: str = ""
    capture: str = "asking the board"
    verdict: str = ""
    gave: str = ""
    hypotheses: list[HypothesisDocument] = field(default_factory=list)
    before: Mapping[str, float] = field(default_factory=dict)
    finished: bool = False


class GuideRun(CaptureObserver):
    """A guided test in a thread of its own, watched by every tab; it is its own watcher, and that of its captures."""

    def __init__(self, board: AbstractContextManager[str], test: GuidedTest) -> None:
        self.now = GuideNow()
        self._board, self._test, self._ended = board, test, False
        threading.Thread(target=self._run, name="guide", daemon=True).start()

    def cancel(self) -> None:
        """End it; what was recorded is kept."""
        self._ended = True

    def asks(self, number: int, told: Guidance) -> None:
        """Note what to release, and why."""
        self.now = replace(self.now, to_do=f"Release {number}: {to_do(told)}", why=told.words)

    def observer(self) -> CaptureObserver:
        """Return the observer of a capture."""
        return self

    def state(self, name: str, detail: str) -> None:
        """Note where the capture stands."""
        self.now = replace(self.now, capture=f"{STATES.get(name, name)}: {detail}")

    def block(self, first_index: int, samples: np.ndarray) -> None:
        """Leave the capture the way Ctrl-C does where it was cancelled."""
        if self._ended:
            raise KeyboardInterrupt("cancelled on the workbench")

    def provisional(self, answer: str) -> None:
        """Note a first answer."""
        self.now = replace(self.now, verdict=f"So far: {answer}")

    def judged(self, turn: TurnDocument, document: DiagnosisDocument | None) -> None:
        """Note the verdict, the odds, and what the release gave."""
        if document is None:
            self.now = replace(self.now, verdict=f"It told nothing: {turn.problem}", gave="")
            return
        self.now = replace(
            self.now,
            verdict=headline(document),
            gave=gave(turn),
            hypotheses=turn.hypotheses[:_SHOWN],
            before=odds_of(self.now.hypotheses),
        )

    def _run(self) -> None:
        try:
            with self._board as port:
                test = replace(self._test, port=port)
                document = guide(test, self, lambda: self._ended)
            self.now = replace(self.now, capture="writing the report")
            document = finish_guided(test, document)
            last = f"{ENDINGS[document.state][0]}. {document.words}"
            self.now = replace(
                self.now, to_do=last, why=f"All of it: {document.folder}", capture="", finished=True
            )
        except KeyboardInterrupt:
            self._fail("cancelled; what was recorded is kept")
        except Exception as error:
            self._fail(sentence_of(error))

    def _fail(self, problem: str) -> None:
        self.now = replace(self.now, to_do=sentence(problem.rstrip(".")), why="", capture="", finished=True)


class GuidePanel:
    """What begins a guided test and shows how it goes on."""

    def __init__(self, settings: Settings, busy: Callable[[], bool]) -> None:
        self._settings, self._busy = settings, busy
        self._run: GuideRun | None = None
        self._shown: GuideNow | None = None
        with ui.expansion("Guided test").props("dense").classes("card"):
            with ui.element("div") as self._form:
                with widgets.line():
                    self._low = widgets.number("Least, mm", 2.0)
                    self._high = widgets.number("Largest, mm", 25.0)
                self._port = ui.input("Port", value=settings.capture.port or "").props("dense outlined")
                self._alone = ui.checkbox("The rig releases itself")
                widgets.button("Begin", self._begin, "Begin the guided test", strong=True, classes="wide")
                widgets.button("No board? On a simulated rig", self._simulate, classes="wide")
            self._place = widgets.html().props("aria-live=polite")
            self._stop = widgets.button(
                "Stop", lambda: self._run.cancel() if self._run else None, "Stop the guided test"
            )
            self._stop.set_visibility(False)
        ui.timer(TICK_S, self._tick)

    def _begin(self) -> None:
        low, high = (1e-3 * (field.value or 0.0) for field in (self._low, self._high))
        port = str(self._port.value or "").strip()
        if not (0.0 < low < high and port):
            ui.notify("give the port, and two amplitudes above 0, the smaller one first", type="warning")
            return
        ways = ("longer", "rest") if self._alone.value else ("push", "longer", "rest")
        wanted = capture_settings(self._settings, session_info(self._settings))
        self._start(nullcontext(port), wanted, Limits(low, high, ways=ways), bool(self._alone.value))

    def _simulate(self) -> None:
        _, board, wanted = mystery(self._settings, *RIG)
        self._start(board, wanted, SIMULATED, True)

    def _start(
        self, board: AbstractContextManager[str], wanted: CaptureSettings, limits: Limits, alone: bool
    ) -> None:
        if self._busy() or (self._run is not None and not self._run.now.finished):
            ui.notify("a recording is under way: this click started nothing", type="warning")
            return
        folder = new_folder(self._settings.sessions, "guide")
        self._run = GuideRun(board, GuidedTest("", wanted, limits, folder, self._settings, alone))

    def _tick(self) -> None:
        if self._run is None or self._run.now is self._shown:
            return
        now = self._shown = self._run.now
        self._form.set_visibility(now.finished)
        self._stop.set_visibility(not now.finished)
        said = [
            (now.to_do, "strong"),
            (now.why, "small"),
            (now.capture, "small faint"),
            (now.verdict, "strong"),
            (f"It gave {now.gave}." if now.gave else "", "small"),
        ]
        self._place.content = part("lines", said) + part("odds", now.hypotheses, now.before)
