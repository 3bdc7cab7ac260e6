"""The middle while a board is being recorded: the live scope, what to do now, and what to write down beside it."""

import json
from dataclasses import asdict

from nicegui import ui

from station.text.numbers import typeset
from station.workbench import widgets
from station.workbench.capture_run import CaptureRun, Level, Progress
from station.workbench.sessions_panel import address_of
from station.workbench.widgets import run

TICK_S = 0.1


class ScopePanel:
    """Shown in the tab that records; it opens the session when that is sealed."""

    def __init__(self) -> None:
        self._run: CaptureRun | None = None
        self._shown: Progress | None = None
        self._levels: list[tuple[ui.element, ui.label]] = []

    def build(self) -> None:
        """Make the panel, unseen."""
        self._panel = ui.element("section").classes("scope-panel").props('aria-label="The scope"')
        with self._panel:
            with ui.element("div").classes("statement").props("aria-live=assertive") as self._statement:
                self._count = widgets.label("", "big")
                with ui.element("div").classes("grow"):
                    self._what = widgets.label("", "what")
                    self._more = widgets.label("", "more")
                widgets.button(
                    "Cancel", lambda: self._run.cancel() if self._run else None, "Cancel the capture"
                )
            self._bar = ui.linear_progress(0.0, show_value=False).props("instant-feedback rounded")
            with ui.element("div").classes("scope-row"):
                widgets.chart("scope", "Live scope", "scope")
                with ui.element("div").classes("scope-fields"):
                    self._fields()
            self._bars = ui.element("div").classes("card tight")
        self._panel.set_visibility(False)
        ui.timer(TICK_S, self._tick)

    def _fields(self) -> None:
        widgets.head("Write down meanwhile")
        for key, label in (
            ("name", "Name of the session"),
            ("specimen", "Specimen"),
            ("operator", "Operator"),
        ):
            field = ui.input(label, on_change=lambda e, k=key: self._note(k, str(e.value or "") or None))
            field.props("dense outlined autocomplete=off")
        ui.number(
            "Mass, kg", min=0, format="%g", on_change=lambda e: self._note("mass_kg", e.value or None)
        ).props("dense outlined")
        widgets.label("Kept with the recording when it is sealed.", "small faint wrap")

    def _note(self, key: str, value: object) -> None:
        if self._run is not None:
            self._run.written[key] = value

    def follow(self, capture: CaptureRun) -> None:
        """Show a capture from now on."""
        self._run, self._shown, self._levels = capture, None, []
        self._panel.set_visibility(True)

    @property
    def visible(self) -> bool:
        """Whether the panel has the middle."""
        return bool(self._panel.visible)

    def _tick(self) -> None:
        if self._run is None or self._run.now is self._shown:
            return
        now, self._shown = self._run.now, self._run.now
        if now.finished:
            self._run = None
            self._panel.set_visibility(False)
            if now.session is not None and not now.problem:
                ui.navigate.to(address_of(now.session.name))
            return
        self._statement.props["data-kind"] = {"armed": "floor", "recording": "preview"}.get(now.state, "film")
        self._statement.update()
        left = now.scope.left_s
        self._count.text = "" if left is None else f"{left:.1f} s"
        self._what.text = now.sentence[:1].upper() + now.sentence[1:]
        lost = f" {now.lost} samples lost so far; they are asked for again." if now.lost else ""
        self._more.text = typeset(f"{now.detail}{lost}")
        self._bar.value = now.recorded
        self._move(now.levels)
        run(f"bench.scope({json.dumps(asdict(now.scope))})")

    def _move(self, levels: tuple[Level, ...]) -> None:
        if len(levels) != len(self._levels):
            self._bars.clear()
            self._levels = []
            with self._bars:
                for level in levels:
                    with widgets.line("small"):
                        widgets.label(level.channel).style("width:110px")
                        with ui.element("div").classes("level grow"):
                            bar = ui.element("i")
                        number = widgets.label("", "mono").style("width:130px; text-align:right")
                    self._levels.append((bar, number))
        for (bar, number), level in zip(self._levels, levels, strict=False):
            number.text = f"{level.value:.4g} {typeset(level.unit)}"
            half = 50.0 * min(abs(level.share), 1.0)
            start = 50.0 if level.share >= 0 else 50.0 - half
            bar.style(f"left:{start:.1f}%; width:{half:.1f}%")
