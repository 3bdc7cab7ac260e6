"""Right, the loop: the model, what it lacks, an effect of one's own, and the ladder of errors."""

from nicegui import ui

from station.results.ladder import KeptLadder
from station.results.models import name_of
from station.text.ladder_text import step
from station.text.layout import sentence
from station.text.numbers import change, three_figures, typeset, with_unit
from station.workbench import view_models, widgets
from station.workbench.ladder_bars import share
from station.workbench.own_panel import OwnPanel
from station.workbench.session_state import SessionState
from station.workbench.suspects_panel import SuspectsPanel
from station.workbench.theme import Theme


class LoopPanel:
    """Model, suspects, own effect and ladder of one session."""

    def __init__(self, session: SessionState) -> None:
        self._session = session
        self._suspects = SuspectsPanel(session)
        self._own = OwnPanel(session)

    def build(self) -> None:
        """Make the panel; it is empty until something is shown. The ladder stays in sight below the rest."""
        with ui.element("div").classes("loop-scroll"):
            with widgets.card():
                self._suspects.build()
            with widgets.card():
                widgets.head("Model")
                self._model = ui.element("div")
            with widgets.card():
                self._own.build()
        with ui.element("section").classes("loop-ladder").props('aria-label="Ladder of errors"'):
            self._ladder = ui.element("div")

    def show(self, view: view_models.View, colours: Theme) -> None:
        """Show a session as it stands."""
        self._model.clear()
        with self._model:
            self._show_model(view)
        self._suspects.show(view, self._session.force_maps, colours)
        self._ladder.clear()
        with self._ladder:
            self._show_ladder(view.ladder)

    def _show_model(self, view: view_models.View) -> None:
        top = view.ladder.top
        for entry in top.model.effects:
            with ui.element("div").classes("effect"):
                with widgets.line():
                    switch = ui.switch(value=True, on_change=lambda e, n=entry.effect: self._turn(n, e.value))
                    switch.props("dense size=sm").props["aria-label"] = f"{entry.effect} in the model"
                    widgets.label(_called(entry.effect), "strong grow wrap")
                    widgets.label(view.equations.get(entry.effect, ""), "mono faint")
                with ui.element("div").classes("values small"):
                    for name, value in entry.parameters.items():
                        widgets.label(f"{name} = {typeset(with_unit(value))}")
        for name in _switched_off(view.ladder):
            with ui.element("div").classes("effect off"), widgets.line():
                switch = ui.switch(value=False, on_change=lambda e, n=name: self._turn(n, e.value))
                switch.props("dense size=sm").props["aria-label"] = f"{name} in the model"
                widgets.label(f"{_called(name)} (off)", "grow wrap")

    def _turn(self, name: str, on: bool) -> None:
        if on:
            text = _expression(self._session.view.ladder, name) if self._session.view else ""
            self._session.start(f"Adding {_called(name)}", "add", text or name)
        else:
            self._session.start(f"Taking {_called(name)} out", "remove", name)
        self._session.version += 1

    def _show_ladder(self, ladder: KeptLadder) -> None:
        with widgets.line():
            with ui.element("div").classes("grow"):
                widgets.head("Rung by rung")
            widgets.label("chi2; green: noise floor", "small faint")
        before = None
        for place, rung in enumerate(ladder.rungs):
            kind = "present" if place == ladder.present else "above" if place > ladder.present else ""
            row = ui.element("button").classes(f"rung {kind}").on("click", lambda n=place: self._go(n))
            row.props["type"] = "button"
            row.props["aria-label"] = (
                f"go to rung {place}: {step(rung)}, chi2 {three_figures(rung.error.chi2)}"
            )
            with row:
                widgets.label(str(place), "faint")
                widgets.label(step(rung), "what")
                widgets.label(
                    "" if before is None else change(before.error.chi2, rung.error.chi2), "small faint"
                )
                widgets.label(three_figures(rung.error.chi2), "value strong")
                filled, floor = share(rung.error.chi2, ladder)
                with ui.element("div").classes("track"):
                    ui.element("div").classes("fill").style(f"width:{filled:.1f}%")
                    ui.element("div").classes("floor").style(f"left:{floor:.1f}%")
            before = rung
        if ladder.stopped_because:
            widgets.label(sentence(ladder.stopped_because), "small wrap")
        with widgets.line():
            widgets.button(
                "Add all that is missing", lambda: self._session.start("Refining", "refine", long=True)
            )
            if len(ladder.rungs) > 1:
                widgets.button("Begin again", lambda: self._session.start("Beginning again", "again"))

    def _go(self, number: int) -> None:
        ladder = self._session.view.ladder if self._session.view else None
        if ladder is not None and number != ladder.present:
            self._session.start(f"Going to rung {number}", "go", number)


def _called(name: str) -> str:
    return name.replace("_", " ")


def _switched_off(ladder: KeptLadder) -> list[str]:
    """Return effects that stood in the model on the way to the present rung, and do not now."""
    here = set(ladder.top.effects)
    found: dict[str, None] = {}
    for rung in ladder.rungs[: ladder.present + 1]:
        found |= {name: None for name in rung.effects if name not in here}
    return list(found)


def _expression(ladder: KeptLadder, name: str) -> str:
    """Return the user's own text of an effect; "" where the library has it."""
    for rung in ladder.rungs:
        for text in rung.model.expressions:
            if name_of(text) == name:
                return text
    return ""
