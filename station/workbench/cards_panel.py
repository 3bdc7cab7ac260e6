"""The suspects as cards under the maps: pointing at one previews it, a click selects it, Add puts it into the model."""

import asyncio
import json
from collections.abc import Callable, Mapping
from typing import Any

from nicegui import ui

from identify.formatting import plain_name
from station.results.diagnosis_document import DiagnosisDocument
from station.story.residual import explained_words
from station.suggestions import MEASURED_CURVE
from station.text.diagnosis_text import confirmed_by, found_in_sensor, not_distinguishable
from station.text.layout import sentence
from station.text.numbers import typeset
from station.workbench import tasks, widgets
from station.workbench.others_menu import others_menu
from station.workbench.parts import part
from station.workbench.session_list import SessionList
from station.workbench.session_state import SessionState
from station.workbench.statements import called
from station.workbench.view_models import MOST_CARDS, Drawn, View
from station.workbench.widgets import run
from station.workbench.worker import Failed

Card = tuple[str, str, str, str, bool]
"""An effect, what it is called, what it explains, its equation, and whether that is no better than chance."""


class CardsPanel:
    """What the present model may lack."""

    def __init__(
        self, session: SessionState, session_list: SessionList, does: Mapping[str, Callable[[str], Any]]
    ) -> None:
        self._session = session
        with ui.element("section").classes("suspects").props('aria-label="Suspects"'):
            with widgets.line("suspects-head"):
                self._head = widgets.label("", "strong wrap grow verdict").props("aria-live=polite")
                self._asks = widgets.html("contents", does)
                self._why = ui.button("Why", color=None).props("dense no-caps flat padding='3px 8px'")
                with self._why, ui.menu().props("max-width=460px"):
                    self._reasons = widgets.html("why")
                others_menu(session, session_list)
            self._cards = widgets.html("cards")
            OwnCard(session)

    def show(self, view: View) -> None:
        """Show the suspects of the present model, or that nobody has asked about it yet."""
        document, floor = view.diagnosis if view.about_present else None, view.at_floor
        self._head.text = _headline(document, floor)
        self._head.classes(remove="good", add="good" if floor else "")
        self._asks.content = part("asks", view, document)
        self._why.set_visibility(document is not None)
        if document is not None:
            confirmed = confirmed_by(document)
            reasons = [
                f"Confirmed on {confirmed}." if confirmed else "",
                sentence(not_distinguishable(document)),
            ]
            faults = [found_in_sensor(finding, advice=True) for finding in document.findings]
            why = (typeset(document.explanation), reasons, faults, document.next_experiment)
            self._reasons.content = part("why", *why)
        cards = [] if document is None else self._offered(document, view)
        self._cards.content = "" if floor else part("cards", cards, document is not None)

    def _offered(self, document: DiagnosisDocument, view: View) -> list[Card]:
        top, found = view.ladder.top, list[Card]()
        offered = [s for s in document.suspects if s.model is not None and s.effect not in top.effects]
        for suspect in offered[:MOST_CARDS]:
            name, words = suspect.effect, "no better than chance"
            if suspect.claimed:
                words = explained_words(top.error.chi2, suspect.error_after, top.chi2_std)
            equation = view.equations.get(name, suspect.title)
            found.append((name, plain_name(name), words, equation, not suspect.claimed))
        curve = self._session.suspects.says.get(MEASURED_CURVE)
        if curve is not None:
            equation = "a spline of the residual, without a name"
            found.append((MEASURED_CURVE, "the measured curve", curve["words"], equation, False))
        return found


def _headline(document: DiagnosisDocument | None, floor: bool) -> str:
    if floor:
        return "Nothing is missing: the residual is noise."
    if document is None:
        return "What is missing?"
    if not document.named:
        unnamed = "Something is missing that has no name here."
        return unnamed if document.suspects else typeset(document.explanation)
    named = " and ".join(plain_name(name) for name in document.named)
    if document.verdict == "sensor_fault":
        return f"A sensor is at fault: {named}."
    return f"The missing effect is {named}."


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
        run("bench.own(null)")
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
        self._say("good", f"{says['what']}. Point here to see it again.")
        run(f"bench.own({json.dumps({'frame': frame, 'says': says, 'name': called(text)})})")

    def _say(self, kind: str, text: str) -> None:
        """Say how the expression is; one that is good can be added."""
        self._message.classes(remove="bad good faint", add=kind)
        self._message.text = text
        self._button.set_enabled(kind == "good")

    def _add(self) -> None:
        if self._button.enabled:
            text, self._field.value = self._typed, ""
            self._session.add(text)
