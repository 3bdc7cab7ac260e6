"""Right, the fall: the ladder of errors as a film, the model with its values, and what to do at the floor."""

from functools import partial

from nicegui import ui

from identify.formatting import plain_name
from station.results.ladder import KeptLadder
from station.story.residual import times
from station.workbench import view_models, widgets
from station.workbench.floor_card import FloorCard
from station.workbench.ladder_bars import share
from station.workbench.model_card import ModelCard, title
from station.workbench.session_state import SessionState


class LadderPanel:
    """Ladder and model of one session."""

    def __init__(self, session: SessionState, floor: FloorCard) -> None:
        self._session = session
        self._floor = floor
        self._model = ModelCard(session)
        self._shown: object = None

    def build(self) -> None:
        """Make the panel; it is empty until something is shown."""
        with ui.element("section").classes("card ladder").props('aria-label="Ladder of errors"'):
            with widgets.line():
                with ui.element("div").classes("grow"):
                    widgets.head("Step by step")
                self._undo = widgets.button("Undo", self._session.undo, "Undo the last change of the model")
            widgets.label(
                "residual, times the noise (bars logarithmic; green line: noise alone)", "small faint"
            )
            self._steps = ui.element("div")
            self._ghost()
            self._film = ui.element("div").classes("film")
        self._floor.build()
        self._model.build()

    def _ghost(self) -> None:
        row = ui.element("div").classes("step-ghost").props("id=ghost-step aria-hidden=true")
        with row:
            widgets.label("+", "faint")
            widgets.label("", "what")
            widgets.label("", "value strong")
            with ui.element("div").classes("track"):
                ui.element("div").classes("fill")
                self._ghost_floor = ui.element("div").classes("floor")

    def show(self, view: view_models.View) -> None:
        """Show a session as it stands."""
        ladder = view.ladder
        self._undo.set_enabled(bool(self._session.earlier))
        if (ladder.present, ladder.steps) != self._shown:
            self._shown = ladder.present, ladder.steps
            self._show_steps(ladder)
            self._floor.show(view)
        self._model.show(view)

    def _show_steps(self, ladder: KeptLadder) -> None:
        _, floor = share(None, ladder)
        self._ghost_floor.style(f"left:{floor:.1f}%")
        self._steps.clear()
        with self._steps:
            for place in range(len(ladder.steps)):
                self._step(ladder, place)
        self._film.clear()
        with self._film:
            self._slider(ladder)

    def _step(self, ladder: KeptLadder, place: int) -> None:
        step = ladder.steps[place]
        kind = "present" if place == ladder.present else "above" if place > ladder.present else ""
        floor = " reached" if step.at_floor else ""
        row = ui.element("button").classes(f"step {kind}{floor}").on("click", partial(self._go, place))
        row.props["type"] = "button"
        row.props["aria-label"] = (
            f"go to step {place}: {_step(ladder, place)}, {times(step.error.chi2)} times the noise"
        )
        if place == ladder.present:
            row.props["aria-current"] = "step"
        with row:
            widgets.label(str(place), "faint")
            widgets.label(_step(ladder, place), "what")
            widgets.label(times(step.error.chi2), "value strong")
            filled, at = share(step.error.chi2, ladder)
            with ui.element("div").classes("track"):
                ui.element("div").classes("fill").style(f"width:{filled:.1f}%")
                ui.element("div").classes("floor").style(f"left:{at:.1f}%")

    def _slider(self, ladder: KeptLadder) -> None:
        last = len(ladder.steps) - 1
        if last == 0:
            return
        slider = ui.element("input").props(
            f"id=film type=range min=0 max={last} step=1 value={ladder.present}"
        )
        slider.props["aria-label"] = "Look at the steps one after another"
        with widgets.line("small"):
            widgets.label("slide through the steps; a click on one goes back to it", "faint grow")
            widgets.label("", "strong").props("id=film-words")

    def _go(self, number: int) -> None:
        ladder = self._session.view.ladder if self._session.view else None
        if ladder is not None and number != ladder.present:
            self._session.start(f"Going to step {number}", "go", number)


def _step(ladder: KeptLadder, place: int) -> str:
    step = ladder.steps[place]
    if step.added:
        return f"+ {plain_name(step.added)}"
    if step.removed:
        return f"− {plain_name(step.removed)}"
    return step.began if place == 0 else title("model")
