"""At the floor: that the model is adequate, its equation, and what to do with it."""

from collections.abc import Callable

from nicegui import ui

from identify.formatting import plain_name
from station.story.residual import floor_words
from station.text.numbers import typeset
from station.workbench import view_models, widgets


class FloorCard:
    """Shown when nothing but noise is left."""

    def __init__(
        self, report: Callable[[], object], validate: Callable[[], object], prune: Callable[[], object]
    ) -> None:
        self._report, self._validate, self._prune = report, validate, prune

    def build(self) -> None:
        """Make the card, unseen."""
        self._card = ui.element("section").classes("card floor-card").props('aria-label="At the noise floor"')
        with self._card:
            widgets.label("At the noise floor", "floor-title")
            self._words = widgets.label("", "small wrap")
            with widgets.line("wrapping"):
                widgets.button("Report", self._report, "Write the report of this model", strong=True)
                widgets.button("Validate on another release", self._validate)
                widgets.button("Drop what is not needed", self._prune)
            self._equation = widgets.label("", "mono wrap")
        self._card.set_visibility(False)

    def show(self, view: view_models.View) -> None:
        """Show the card where the present model reaches the floor."""
        top = view.ladder.top
        self._card.set_visibility(view.at_floor)
        if not view.at_floor:
            return
        self._words.text = (
            f"The {top.name} leaves {top.error.words} (noise alone: "
            f"{floor_words(top.chi2_std)}). Added to the {view.ladder.steps[0].began}: "
            f"{', '.join(plain_name(n) for n in top.effects if n not in view.ladder.steps[0].effects) or 'nothing'}."
        )
        self._equation.text = typeset(top.model.equation)
