"""The model: its effects with equations and values, each of which can be taken out and put in again."""

from nicegui import ui

from identify.formatting import plain_name
from station.results.ladder import KeptLadder
from station.results.models import EffectEntry, name_of
from station.text.numbers import with_unit
from station.workbench import view_models, widgets
from station.workbench.session_state import SessionState


class ModelCard:
    """The present model of one session."""

    def __init__(self, session: SessionState) -> None:
        self._session = session
        self._shown: object = None

    def build(self) -> None:
        """Make the card."""
        with widgets.card():
            widgets.head("The model")
            self._body = ui.element("div")

    def show(self, view: view_models.View) -> None:
        """Show the present model, and the effects that were taken out on the way to it."""
        now = (view.ladder.present, view.ladder.steps)
        if now == self._shown:
            return
        self._shown = now
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
                    widgets.label(what + whole, look)
                    what, look = "per unit mass ", "small faint indent"
                widgets.label(what + with_unit(value), look)

    def _switch(self, name: str, on: bool) -> None:
        switch = ui.switch(value=on, on_change=lambda e: self._turn(name, bool(e.value)))
        switch.props("dense size=sm").props["aria-label"] = f"{plain_name(name)} in the model"

    def _turn(self, name: str, on: bool) -> None:
        self._shown = None
        if on:
            text = expression_of(self._session.view.ladder, name) if self._session.view else ""
            self._session.start(f"Adding {plain_name(name)}", "add", text or name)
        else:
            self._session.start(f"Taking {plain_name(name)} out", "remove", name)
        self._session.changed()


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


def title(name: str) -> str:
    """Return an effect's name for people as the beginning of a line."""
    words = plain_name(name)
    return f"{words[:1].upper()}{words[1:]}"
