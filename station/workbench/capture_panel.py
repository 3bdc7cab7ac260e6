"""Left, the capture: a port, a large Arm button, live levels, progress, and the verdict after it."""

import asyncio

from nicegui import ui

from daq.errors import StationError
from station.exits import Problem
from station.text.layout import sentence
from station.workbench import widgets
from station.workbench.app_state import AppState
from station.workbench.capture_run import CaptureRun, Level, Progress
from station.workbench.sessions_panel import address_of

TICK_S = 0.1


class CapturePanel:
    """What records a release."""

    def __init__(self, state: AppState) -> None:
        self._state = state
        self._shown: Progress | None = None
        self._levels: list[tuple[ui.element, ui.label]] = []

    def build(self) -> None:
        """Make the panel."""
        settings = self._state.settings
        with widgets.card():
            widgets.head("Capture a release")
            with ui.element("div") as self._form:
                with widgets.line():
                    self._port = ui.select(
                        self._known(), value=settings.capture.port, label="Port", with_input=True,
                        new_value_mode="add-unique", clearable=True,
                    ).props('dense outlined options-dense aria-label="Port of the board"').classes("grow")  # fmt: skip
                    widgets.button("Find", self._find, "Ask every port whether a board answers there")
                with widgets.line().style("padding-top:6px"):
                    self._mass = _field("Mass, kg", settings.specimen.mass_kg)
                    self._duration = _field("Record, s", settings.capture.duration)
                self._arm = widgets.button("Arm", self._start, "Arm the capture", strong=True, classes="arm")
                self._arm.style("width:100%; height:52px; margin-top:8px")
            self._message = ui.element("div").props("aria-live=polite")
        ui.timer(TICK_S, self._tick)

    def _known(self) -> list[str]:
        from daq.port import system_ports

        known = [port.name for port in system_ports()]
        wanted = self._state.settings.capture.port
        return list(dict.fromkeys([*([wanted] if wanted else []), *known]))

    async def _find(self) -> None:
        from daq.ports import list_ports

        self._say([("asking every port, at most 3 s", "faint")])
        found = await asyncio.to_thread(list_ports, [self._port.value] if self._port.value else [])
        answering = [one for one in found if one.answers and not one.problem]
        if answering:
            names = [one.port.name for one in answering]
            self._port.set_options(list(dict.fromkeys([*names, *self._port.options])), value=names[0])
        lines = [(f"{one.port.name}: {one.hello.board}", "good") for one in answering if one.hello]
        lines += [(one.problem, "bad") for one in found if one.answers and one.problem]
        self._say(lines or [("no board answers; plug it in, or type its port", "bad")])

    def _start(self) -> None:
        if self._state.capturing is not None and not self._state.capturing.now.finished:
            ui.notify("another tab is recording: this click started nothing", type="warning")
            return
        port = str(self._port.value or "").strip()
        if not port:
            self._say([("choose the port of the board, or let Find look for it", "bad")])
            return
        from station.operations.new_session import capture_settings, session_info

        settings = self._state.settings
        try:
            info = session_info(settings, self._mass.value or None, None, None, None)
            wanted = capture_settings(settings, info, duration=self._duration.value)
        except (StationError, Problem, ValueError) as error:
            self._say([(str(error).splitlines()[0], "bad")])
            return
        self._state.capturing = CaptureRun(port, wanted, settings.sessions)

    def _cancel(self) -> None:
        if self._state.capturing is not None:
            self._state.capturing.cancel()

    def _tick(self) -> None:
        run = self._state.capturing
        if run is None or run.now is self._shown:
            return
        now, before = run.now, self._shown
        self._shown = now
        self._form.set_visibility(now.finished)
        if now.finished:
            self._finished(now)
            return
        if (
            before is None
            or _state_of(before) != _state_of(now)
            or len(before.levels) != len(now.levels)
            or before.finished
        ):
            self._under_way(now)
        self._move(now.levels)
        self._bar.value = now.recorded

    def _under_way(self, now: Progress) -> None:
        self._message.clear()
        self._levels = []
        with self._message:
            widgets.label(now.sentence, f"strong wrap {'good' if now.state == 'armed' else ''}").style(
                "font-size:17px"
            )
            silent = now.detail.startswith("nothing came")
            widgets.label(now.detail, f"small wrap {'bad strong' if silent else 'faint'}")
            if now.lost:
                widgets.label(f"{now.lost} samples lost so far; they are asked for again", "small bad")
            for level in now.levels:
                with widgets.line("small"):
                    widgets.label(level.channel, "grow")
                    number = widgets.label("", "mono")
                with ui.element("div").classes("level"):
                    bar = ui.element("i")
                self._levels.append((bar, number))
            self._bar = ui.linear_progress(0.0, show_value=False).props("instant-feedback rounded")
            widgets.button("Cancel", self._cancel, "Cancel the capture").style("width:100%; margin-top:6px")

    def _move(self, levels: tuple[Level, ...]) -> None:
        for (bar, number), level in zip(self._levels, levels, strict=False):
            number.text = f"{level.value:.4g} {level.unit}"
            half = 50.0 * min(abs(level.share), 1.0)
            start = 50.0 if level.share >= 0 else 50.0 - half
            bar.style(f"left:{start:.1f}%; width:{half:.1f}%")

    def _finished(self, now: Progress) -> None:
        self._message.clear()
        with self._message:
            if now.problem:
                widgets.label(sentence(now.problem), "bad small wrap")
                if now.kept is not None:
                    widgets.label("What was received is in the list below.", "small faint wrap")
                return
            good = now.verdict == "OK"
            widgets.label(now.verdict or "recorded", f"strong {'good' if good else 'bad'}").style(
                "font-size:17px"
            )
            for reason in now.reasons:
                widgets.label(reason, "small wrap")
            for advice in now.advice:
                widgets.label(f"To take it again: {advice}", "small wrap")
            if now.session is not None:
                key = now.session.name
                widgets.button(f"Open {key}", lambda: ui.navigate.to(address_of(key)), strong=True)

    def _say(self, lines: list[tuple[str, str]]) -> None:
        self._message.clear()
        with self._message:
            for text, kind in lines:
                widgets.label(text, f"small wrap {kind}")


def _field(label: str, value: float | None) -> ui.number:
    made = ui.number(label, value=value, min=0, format="%g")
    made.props(f'dense outlined aria-label="{label}"').style("flex:1; min-width:0")
    return made


def _state_of(now: Progress) -> tuple[str, str, int]:
    return now.state, now.detail, now.lost
