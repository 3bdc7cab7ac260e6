"""Left, the capture: a port, a large Arm button, and what came of it. While it runs the scope has the middle."""

import asyncio
import secrets
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace

from nicegui import ui

from daq.errors import StationError
from station.exits import Problem
from station.text.layout import sentence
from station.workbench import widgets
from station.workbench.app_state import AppState
from station.workbench.capture_run import CaptureRun, Progress
from station.workbench.doubles import doubles
from station.workbench.sessions_panel import address_of

TICK_S = 0.1
MYSTERIES = 1000
MYSTERY_KG = 21.36
"""Of the simulated bench."""

MYSTERY_SPEED = 2.0


class CapturePanel:
    """What records a release; `began` is called when this tab begins to record."""

    def __init__(self, state: AppState, began: Callable[[CaptureRun], None], chosen: str | None) -> None:
        self._state, self._began, self._chosen = state, began, chosen
        before = state.capturing
        self._shown: Progress | None = before.now if before is not None and _is_past(before, chosen) else None
        self._own: CaptureRun | None = None

    def build(self) -> None:
        """Make the panel."""
        settings = self._state.settings
        with widgets.card():
            widgets.head("Record a release")
            with ui.element("div") as self._form:
                with widgets.line():
                    self._port = ui.select(
                        self._known(), value=settings.capture.port, label="Port", with_input=True,
                        new_value_mode="add-unique",
                    ).props('dense outlined options-dense aria-label="Port of the board"').classes("grow")  # fmt: skip
                find = widgets.button(
                    "Find the board", self._find, "Find: ask every port whether a board answers there"
                )
                find.style("width:100%; margin-top:6px")
                with widgets.line().style("padding-top:6px"):
                    self._mass = _field("Mass, kg", settings.specimen.mass_kg)
                    self._duration = _field("Record, s", settings.capture.duration)
                self._arm = widgets.button("Arm", self._start, "Arm the capture", strong=True, classes="arm")
                self._arm.style("width:100%; height:46px; margin-top:8px")
                mystery = widgets.button("No board? Solve a mystery", self.solve_mystery, classes="mystery")
                mystery.style("width:100%; margin-top:6px")
            self._message = ui.element("div").props("aria-live=polite")
        ui.timer(TICK_S, self._tick)

    def busy(self) -> bool:
        """Whether a capture is under way, in whichever tab."""
        return self._state.capturing is not None and not self._state.capturing.now.finished

    def _known(self) -> list[str]:
        from daq.port import system_ports

        known = [port.name for port in system_ports()]
        wanted = self._state.settings.capture.port
        return list(dict.fromkeys([*([wanted] if wanted else []), *doubles(), *known]))

    async def _find(self) -> None:
        from daq.ports import list_ports

        self._say([("asking every port, at most 3 s", "faint")])
        named = [*([self._port.value] if self._port.value else []), *doubles()]
        found = await asyncio.to_thread(list_ports, named)
        answering = [one for one in found if one.answers and not one.problem]
        if answering:
            names = [one.port.name for one in answering]
            self._port.set_options(list(dict.fromkeys([*names, *self._port.options])), value=names[0])
        lines = [(f"{one.port.name}: {one.hello.board}", "good") for one in answering if one.hello]
        lines += [(one.problem, "bad") for one in found if one.answers and one.problem]
        self._say(lines or [("no board answers; plug it in, type its port, or solve a mystery", "bad")])

    def _start(self) -> None:
        if self.busy():
            ui.notify("another tab is recording: this click started nothing", type="warning")
            return
        port = str(self._port.value or "").strip()
        if not port:
            self._say([("choose the port of the board, or let Find look for it", "bad")])
            return
        self._record(nullcontext(port), self._mass.value or None, self._duration.value)

    def solve_mystery(self) -> None:
        """Record a simulated board that hides something, as if it stood on the bench."""
        from station.operations.simulated_board import simulated_board

        seed = secrets.randbelow(MYSTERIES)
        board = simulated_board(seed, MYSTERY_SPEED, False, module="mocks.mystery")
        self._record(board, MYSTERY_KG, None, seed)

    def _record(
        self,
        board: AbstractContextManager[str],
        mass: float | None,
        duration: float | None,
        mystery: int | None = None,
    ) -> None:
        from station.operations.new_session import capture_settings, session_info

        if self.busy():
            return
        settings = self._state.settings
        if mass is not None and not mass > 0:
            self._say([(f"the mass must be more than 0 kg, not {mass:g} kg", "bad")])
            return
        try:
            info = session_info(settings, mass, None, None if mystery is None else f"mystery {mystery}", None)
            wanted = capture_settings(settings, info, duration=duration)
        except (StationError, Problem, ValueError) as error:
            self._say([(str(error).splitlines()[0], "bad")])
            return
        if mystery is not None:
            wanted = replace(wanted, check_clock=False)
        prefix = "release" if mystery is None else f"mystery_{mystery}"
        self._state.capturing = CaptureRun(board, wanted, settings.sessions, prefix)
        self._own = self._state.capturing
        self._began(self._own)

    def _tick(self) -> None:
        run = self._state.capturing
        if run is None or run.now is self._shown:
            return
        now, before = run.now, self._shown
        self._shown = now
        if before is not None and (before.state, before.detail, before.finished) == (
            now.state,
            now.detail,
            now.finished,
        ):
            return
        self._form.set_visibility(now.finished)
        if not now.finished and run is self._own:
            self._say([("recording: see the scope", "faint")])
            return
        if now.finished:
            self._finished(now)
        else:
            silent = now.detail.startswith("nothing came")
            self._say([(now.sentence, "strong"), (now.detail, "bad strong" if silent else "faint")])

    def _finished(self, now: Progress) -> None:
        self._message.clear()
        with self._message:
            if now.problem:
                widgets.label(sentence(now.problem), "bad small wrap")
                if now.kept is not None:
                    widgets.label("What was received is in the list below.", "small faint wrap")
            verdict = now.verdict
            good = verdict is not None and verdict.grade.value == "OK"
            if now.session is None or (now.session.name == self._chosen and good):
                return
            widgets.label(
                verdict.grade.value if verdict else "recorded", f"strong {'good' if good else 'bad'}"
            )
            for words in (
                (*verdict.reasons, *(f"To take it again: {one}" for one in verdict.advice)) if verdict else ()
            ):
                widgets.label(words, "small wrap")
            key = now.session.name
            if key != self._chosen:
                widgets.button(f"Open {key}", lambda: ui.navigate.to(address_of(key)), strong=True)

    def _say(self, lines: list[tuple[str, str]]) -> None:
        self._message.clear()
        with self._message:
            for text, kind in lines:
                widgets.label(text, f"small wrap {kind}")


def _is_past(run: CaptureRun, chosen: str | None) -> bool:
    """Tell whether a capture ended before this tab was opened, and is of another session or of none."""
    now = run.now
    return now.finished and (now.session is None or now.session.name != chosen)


def _field(label: str, value: float | None) -> ui.number:
    made = ui.number(label, value=value, min=0, format="%g")
    made.props(f'dense outlined aria-label="{label}"').style("flex:1; min-width:0")
    return made
