"""The middle while a board is being recorded: the live scope, what to do now, and what to write down beside it."""

import json
from dataclasses import asdict
from functools import partial
from typing import Any

from nicegui import events, ui

from station.text.numbers import typeset
from station.workbench import widgets
from station.workbench.capture_run import CaptureRun, Progress
from station.workbench.parts import begun, part
from station.workbench.session_list import address_of
from station.workbench.widgets import run

TICK_S = 0.1
KINDS = {"armed": "floor", "recording": "preview"}
TEXTS = {"name": "Name of the session", "specimen": "Specimen", "operator": "Operator"}


class ScopePanel:
    """Shown in the tab that records; it opens the session when that is sealed."""

    def __init__(self) -> None:
        self._run: CaptureRun | None = None
        self._shown: Progress | None = None
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
                    widgets.head("Write down meanwhile")
                    for key, label in TEXTS.items():
                        field = ui.input(label, on_change=partial(self._note, key))
                        field.props("dense outlined autocomplete=off")
                    widgets.number("Mass, kg").on_value_change(partial(self._note, "mass_kg"))
                    widgets.label("Kept with the recording when it is sealed.", "small faint wrap")
            self._levels = widgets.html("card tight")
        self._panel.set_visibility(False)
        ui.timer(TICK_S, self._tick)

    def _note(self, key: str, written: events.ValueChangeEventArguments[Any]) -> None:
        if self._run is not None:
            self._run.written[key] = written.value or None

    def follow(self, capture: CaptureRun) -> None:
        """Show a capture from now on."""
        self._run = capture
        self._panel.set_visibility(True)

    @property
    def visible(self) -> bool:
        """Whether the panel has the middle."""
        return bool(self._panel.visible)

    def _tick(self) -> None:
        if self._run is None or self._run.now is self._shown:
            return
        now = self._shown = self._run.now
        if now.finished:
            self._run = None
            self._panel.set_visibility(False)
            if now.session is not None and not now.problem:
                ui.navigate.to(address_of(now.session.name))
            return
        self._statement.props["data-kind"] = KINDS.get(now.state, "film")
        left = now.scope.left_s
        self._count.text = "" if left is None else f"{left:.1f} s"
        self._what.text = begun(now.sentence)
        lost = f" {now.lost} samples lost so far; they are asked for again." if now.lost else ""
        self._more.text = typeset(f"{now.detail}{lost}")
        self._bar.value = now.recorded
        self._levels.content = part("levels", now.levels)
        run(f"bench.scope({json.dumps(asdict(now.scope))})")
