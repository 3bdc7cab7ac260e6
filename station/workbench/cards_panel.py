"""The suspects as cards under the maps: pointing at one previews it, a click selects it, Add puts it into the model."""

import asyncio
import json
from collections.abc import Callable, Mapping
from typing import Any

from nicegui import ui

from station.operations.workers import Failed
from station.suggestions import MEASURED_CURVE
from station.workbench import tasks, widgets
from station.workbench.others_menu import others_menu
from station.workbench.parts import part
from station.workbench.session_list import SessionList
from station.workbench.session_state import SessionState
from station.workbench.statements import called
from station.workbench.view_models import MOST_CARDS, Drawn, View


class CardsPanel:
    """What the present model may lack."""

    def __init__(
        self, session: SessionState, session_list: SessionList, does: Mapping[str, Callable[[str], Any]]
    ) -> None:
        self._session = session
        with ui.element("section").classes("suspects").props('aria-label="Suspects"'):
            with widgets.line("suspects-head"):
                self._head = widgets.html("strong wrap grow verdict").props("aria-live=polite")
                self._asks = widgets.html("contents", does)
                self._why = ui.button("Why", color=None).props("dense no-caps flat padding='3px 8px'")
                with self._why, ui.menu().props("max-width=460px"):
                    self._reasons = widgets.html("why")
                others_menu(session, session_list)
            self._cards = widgets.html("cards")
            OwnCard(session)

    def show(self, view: View) -> None:
        """Show the suspects of the present model, or that nobody has asked about it yet."""
        document = view.diagnosis if view.about_present else None
        self._head.content = part("verdict", view, document)
        self._asks.content = part("asks", view, document)
        self._why.set_visibility(document is not None)
        if document is not None:
            self._reasons.content = part("why", document)
        curve = self._session.suspects.says.get(MEASURED_CURVE)
        self._cards.content = part("cards", view, document, MOST_CARDS, MEASURED_CURVE, curve)


EXAMPLE = "magnet = a*u/(1 + (u/b)**2)"
PAUSE_S = 0.3
OWN = "(own)"
"""The name under which the expression in the line is previewed; no effect can have it."""

HELP = "A force per unit mass from displacement u, velocity v, time t and parameters of your own; or the name of an effect."


class OwnCard:
    """A line to type in, what is wrong with it beneath, and Add."""

    def __init__(self, session: SessionState) -> None:
        self._session = session
        self._typed = ""
        with ui.element("div").classes("card-suspect own") as self._card:
            with widgets.line():
                widgets.label("One of your own", "name")
                self._field = ui.input(placeholder=EXAMPLE, on_change=lambda e: self._changed(e.value or ""))
                self._field.props(
                    'dense outlined clearable spellcheck=false autocomplete=off aria-label="Effect of your own"'
                )
                self._field.classes("mono grow").on("keydown.enter", self._add)
                self._button = widgets.button("Add", self._add, "Add the effect of your own")
            self._message = widgets.label("", "small wrap").props("aria-live=polite")
        self._say("faint", HELP)

    async def _changed(self, text: str) -> None:
        self._typed = text
        self._button.disable()
        ui.run_javascript("bench.own(null)")
        if not text.strip():
            self._say("faint", HELP)
            return
        await asyncio.sleep(PAUSE_S)
        if text != self._typed:
            return
        view = self._session.view
        try:
            found: Drawn = await self._session.ask(tasks.preview, text)
        except Failed as failure:
            if text == self._typed:
                self._say("bad", str(failure))
            return
        if text != self._typed:
            return
        if self._session.view is not view:  # it was fitted to another model
            await self._changed(text)
            return
        (frame,), (says,) = found.frames.values(), found.says.values()
        self._card.props["data-preview"] = OWN
        self._say("good", f"{says['big']} {says['what']}. Point here to see it again.")
        ui.run_javascript(f"bench.own({json.dumps({'frame': frame, 'says': says, 'name': called(text)})})")

    def _say(self, kind: str, text: str) -> None:
        """Say how the expression is; one that is good can be added."""
        self._message.classes(remove="bad good faint", add=kind)
        self._message.text = text
        self._button.set_enabled(kind == "good")

    def _add(self) -> None:
        if self._button.enabled:
            text, self._field.value = self._typed, ""
            self._session.add(text)
