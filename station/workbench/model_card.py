"""The model: its effects with equations and values, each of which can be moved by hand, taken out and put in again."""

import json
from dataclasses import asdict

from nicegui import background_tasks, ui

from station.results.ladder import KeptLadder
from station.results.models import EffectEntry, Value, name_of
from station.text.numbers import typeset, with_unit
from station.workbench import view_models, widgets
from station.workbench.names import plain, title
from station.workbench.session_state import SessionState
from station.workbench.widgets import run
from station.workbench.worker import Cancelled, Failed, Job

REACH = 0.5
"""Share of a value by which it can be moved by hand to each side; ten standard errors where that is more."""

STEPS = 200


class ModelCard:
    """The present model of one session."""

    def __init__(self, session: SessionState) -> None:
        self._session = session
        self._shown: object = None
        self._moved: dict[str, float] = {}
        self._asking = False

    def build(self) -> None:
        """Make the card."""
        with widgets.card():
            with widgets.line():
                with ui.element("div").classes("grow"):
                    widgets.head("The model")
                self._fitted = widgets.button(
                    "Fitted values", self._take_back, "Take back what was moved by hand"
                )
            self._body = ui.element("div")

    def show(self, view: view_models.View) -> None:
        """Show the present model, and the effects that were taken out on the way to it."""
        now = (view.ladder.present, view.ladder.steps)
        if now == self._shown:
            return
        self._shown = now
        self._moved = {}
        self._fitted.set_visibility(False)
        self._body.clear()
        with self._body:
            for entry in view.ladder.top.model.effects:
                self._effect(entry, view)
            for name in switched_off(view.ladder):
                with ui.element("div").classes("effect off"), widgets.line():
                    self._switch(name, on=False)
                    widgets.label(f"{title(name)} (taken out)", "grow wrap")

    def _effect(self, entry: EffectEntry, view: view_models.View) -> None:
        with ui.element("div").classes("effect"):
            with widgets.line():
                self._switch(entry.effect, on=True)
                widgets.label(title(entry.effect), "strong grow wrap")
            widgets.label(view.equations.get(entry.effect, ""), "mono faint indent")
            for name, value in entry.parameters.items():
                whole, what, look = view.with_mass.get(f"{entry.effect}.{name}"), f"{name} = ", "small indent"
                if whole is not None:
                    widgets.label(what + widgets.whole(typeset(whole)), look)
                    what, look = "per unit mass ", "small faint indent"
                words = widgets.label(what + widgets.whole(typeset(with_unit(value))), look)
                self._slider(f"{entry.effect}.{name}", what, value, words)

    def _slider(self, full: str, what: str, value: Value, words: ui.label) -> None:
        reach = max(REACH * abs(value.value), 10.0 * (value.std or 0.0))
        if reach == 0.0:
            return
        slider = (
            ui.element("input")
            .classes("by-hand")
            .props(f"type=range min={-STEPS} max={STEPS} step=1 value=0")
        )
        effect, _, name = full.partition(".")
        slider.props["aria-label"] = f"Move {name} of {plain(effect)} by hand"

        def moved(event: object) -> None:
            step = int(event.args)  # type: ignore[attr-defined]
            now = value.value + reach * (step / STEPS) ** 3  # fine near the fitted value
            unit = typeset(value.unit)
            words.text = what + (f"{now:.6g} {unit} (moved)" if step else typeset(with_unit(value)))
            self._move(full, now if step else None)

        slider.on("input", moved, js_handler="(e) => emit(Number(e.target.value))", throttle=0.08)

    def _move(self, name: str, value: float | None) -> None:
        if value is None:
            self._moved.pop(name, None)
        else:
            self._moved[name] = value
        self._fitted.set_visibility(bool(self._moved))
        if not self._moved:
            run("bench.receive({trial: null})")
        elif not self._asking:
            background_tasks.create(self._try())

    async def _try(self) -> None:
        """Draw the model as it was moved, as long as it moves on."""
        self._asking = True
        drawn: dict[str, float] = {}
        try:
            while self._moved and self._moved != drawn:
                drawn = dict(self._moved)
                frame = await self._session.ask(Job(), "trial", drawn)
                if frame is not None and self._moved:
                    with self._body:
                        run(f"bench.receive({{trial: {json.dumps(asdict(frame))}}})")
        except (Failed, Cancelled):
            pass  # values at which no motion can be drawn: the last picture stays
        finally:
            self._asking = False

    def _take_back(self) -> None:
        self._shown = None
        self._moved = {}
        run("bench.receive({trial: null})")
        if self._session.view is not None:
            self.show(self._session.view)

    def _switch(self, name: str, on: bool) -> None:
        switch = ui.switch(value=on, on_change=lambda e: self._turn(name, bool(e.value)))
        switch.props("dense size=sm").props["aria-label"] = f"{plain(name)} in the model"

    def _turn(self, name: str, on: bool) -> None:
        self._shown = None
        if on:
            text = expression_of(self._session.view.ladder, name) if self._session.view else ""
            self._session.start(f"Adding {plain(name)}", "add", text or name)
        else:
            self._session.start(f"Taking {plain(name)} out", "remove", name)
        self._session.version += 1


def switched_off(ladder: KeptLadder) -> list[str]:
    """Return effects that stood in the model on the way to the present step, and do not now."""
    here = set(ladder.top.effects)
    found: dict[str, None] = {}
    for step in ladder.steps[: ladder.present + 1]:
        found |= {name: None for name in step.effects if name not in here}
    return list(found)


def expression_of(ladder: KeptLadder, name: str) -> str:
    """Return the user's own text of an effect; "" where the library has it."""
    for step in ladder.steps:
        for text in step.model.expressions:
            if name_of(text) == name:
                return text
    return ""
