"""A release is recorded: on the left a port, a large Arm button and what came of it; in the middle, meanwhile, the scope."""

import asyncio
import json
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import asdict

from nicegui import ui

from daq.capture import CaptureSettings
from daq.errors import StationError
from identify.formatting import sentence_case
from station.exits import Problem
from station.operations.new_session import capture_settings, new_folder
from station.text.layout import sentence
from station.workbench import widgets
from station.workbench.capture_run import CaptureRun, Progress, mystery
from station.workbench.parts import part
from station.workbench.session_list import address_of
from station.workbench.session_state import AppState

TICK_S = 0.1
KINDS = {"armed": "floor", "recording": "preview"}


class CapturePanel:
    """What records a release; `began` is called when this tab begins to record."""

    def __init__(self, state: AppState, began: Callable[[CaptureRun], None], chosen: str | None) -> None:
        self._state, self._began, self._chosen = state, began, chosen
        before = state.capturing.now if state.capturing is not None else None
        past = before is not None and before.finished and before.key != (chosen or "")
        self._shown: Progress | None = before if past else None
        self._own: CaptureRun | None = None
        settings = state.settings
        with widgets.card():
            widgets.head("Record a release")
            with ui.element("div") as self._form:
                with widgets.line():
                    self._port = ui.select(
                        self._known(), value=settings.capture.port, label="Port", with_input=True,
                        new_value_mode="add-unique",
                    ).props('dense outlined options-dense aria-label="Port of the board"')  # fmt: skip
                does = "Find: ask every port whether a board answers there"
                widgets.button("Find the board", self._find, does, classes="wide")
                with widgets.line("apart"):
                    self._mass = widgets.number("Mass, kg", settings.specimen.mass_kg)
                    self._duration = widgets.number("Record, s", settings.capture.duration)
                widgets.button("Arm", self._start, "Arm the capture", strong=True, classes="wide arm")
                widgets.button("No board? Solve a mystery", self.solve_mystery, classes="wide mystery")
            self._message = widgets.html().props("aria-live=polite")
        ui.timer(TICK_S, self._tick)

    def _known(self) -> list[str]:
        from daq.port import system_ports

        wanted = self._state.settings.capture.port
        return list(dict.fromkeys([*([wanted] if wanted else []), *(port.name for port in system_ports())]))

    async def _find(self) -> None:
        from daq.ports import list_ports

        self._say(("asking every port, at most 3 s", "faint"))
        found = await asyncio.to_thread(list_ports, [self._port.value] if self._port.value else [])
        answering = [one for one in found if one.answers and not one.problem]
        if answering:
            names = [one.port.name for one in answering]
            self._port.set_options(list(dict.fromkeys([*names, *self._port.options])), value=names[0])
        lines = [(f"{one.port.name}: {one.hello.board}", "good") for one in answering if one.hello]
        lines += [(one.problem, "bad") for one in found if one.answers and one.problem]
        none = ("no board answers; plug it in, type its port, or solve a mystery", "bad")
        self._say(*(lines or [none]))

    def asked(self) -> tuple[str, CaptureSettings] | None:
        """Read the port, and how to capture, from the form; None where something is wrong, which is said."""
        port = str(self._port.value or "").strip()
        if not port:
            self._say(("choose the port of the board, or press Find the board", "bad"))
            return None
        how = {"mass": self._mass.value or None, "duration": self._duration.value}
        try:
            return port, capture_settings(self._state.settings, **how)
        except (StationError, Problem, ValueError) as error:
            self._say((str(error).splitlines()[0], "bad"))
            return None

    def _start(self) -> None:
        if asked := self.asked():
            port, wanted = asked
            folder = new_folder(self._state.settings.sessions)
            self.begin(lambda: CaptureRun(nullcontext(port), wanted, folder))

    def solve_mystery(self) -> None:
        """Record a simulated board that hides something, as if it stood on the bench."""
        seed, board, wanted = mystery(self._state.settings)
        folder = new_folder(self._state.settings.sessions, f"mystery_{seed}")
        self.begin(lambda: CaptureRun(board, wanted, folder))

    def begin(self, make: Callable[[], CaptureRun]) -> None:
        """Begin to record in this tab, unless one is recording already."""
        before = self._state.capturing
        if before is not None and not before.now.finished:
            ui.notify("a recording is under way: this click started nothing", type="warning")
            return
        self._own = self._state.capturing = make()
        self._began(self._own)

    def _tick(self) -> None:
        run = self._state.capturing
        if run is None or run.now is self._shown:
            return
        now = self._shown = run.now
        self._form.set_visibility(now.finished)
        if now.finished:
            self._finished(run)
        elif run is self._own:
            self._say(("recording: see the scope", "faint"))
        else:
            silent = now.detail.startswith("nothing came")
            self._say((now.sentence, "strong"), (now.detail, "bad strong" if silent else "faint"))

    def _finished(self, run: CaptureRun) -> None:
        now, key = run.now, run.now.key
        kept = "What was received is in the list below." if now.problem and run.folder.is_dir() else ""
        lines = [(sentence(now.problem), "bad"), (kept, "faint")]
        verdict = None if now.session is None else now.session.verdict
        good = verdict is not None and verdict.grade.value == "OK"
        if key and not (key == self._chosen and good):
            lines.append(
                (verdict.grade.value if verdict else "recorded", f"strong {'good' if good else 'bad'}")
            )
            if verdict is not None:
                advice = (f"To take it again: {one}" for one in verdict.advice)
                lines += [(words, "") for words in (*verdict.reasons, *advice)]
        self._say(*lines, opens="" if key == self._chosen else key)

    def _say(self, *lines: tuple[str, str], opens: str = "") -> None:
        said = part("lines", [(text, f"small {kind}") for text, kind in lines])
        self._message.content = said + (part("link", f"Open {opens}", address_of(opens)) if opens else "")


class ScopePanel:
    """Shown in the tab that records, while there is a `run`; it opens the session when that is sealed."""

    def __init__(self) -> None:
        self.run: CaptureRun | None = None
        self._shown: Progress | None = None
        self._panel = ui.element("section").classes("scope-panel").props('aria-label="The scope"')
        with self._panel:
            with ui.element("div").classes("statement").props("aria-live=assertive") as self._statement:
                self._count = widgets.label("", "big")
                with ui.element("div").classes("grow"):
                    self._what = widgets.label("", "what")
                    self._more = widgets.label("", "more")
                widgets.button(
                    "Cancel", lambda: self.run.cancel() if self.run else None, "Cancel the capture"
                )
            widgets.chart("scope", "Live scope", "scope")
            self._levels = widgets.html("card tight")
        self._panel.set_visibility(False)
        ui.timer(TICK_S, self._tick)

    def follow(self, capture: CaptureRun) -> None:
        """Show a capture from now on."""
        self.run = capture
        self._panel.set_visibility(True)

    def _tick(self) -> None:
        if self.run is None or self.run.now is self._shown:
            return
        now = self._shown = self.run.now
        if now.finished:
            self.run = None
            self._panel.set_visibility(False)
            if now.key:
                ui.navigate.to(address_of(now.key))
            return
        self._statement.props["data-kind"] = KINDS.get(now.state, "film")
        left = now.scope.left_s
        self._count.text = "" if left is None else f"{left:.1f} s"
        self._what.text = sentence_case(now.sentence)
        lost = f" {now.lost} samples lost so far; they are asked for again." if now.lost else ""
        self._more.text = f"{now.detail}{lost}"
        self._levels.content = part("levels", now.levels)
        ui.run_javascript(f"bench.scope({json.dumps(asdict(now.scope))})")
