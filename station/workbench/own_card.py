"""A card for an effect of one's own: typed as an expression, checked and previewed as it is typed; parsed, never run."""

import asyncio
import json

from nicegui import ui

from identify.effects.library import LIBRARY
from station.operations import refining
from station.results.models import name_of, parsed_effect
from station.workbench import tasks, widgets
from station.workbench.parts import begun
from station.workbench.session_state import SessionState
from station.workbench.view_models import Drawn
from station.workbench.widgets import run
from station.workbench.worker import Failed

EXAMPLE = "magnet = a*u/(1 + (u/b)**2)"
PAUSE_S = 0.3
OWN = "(own)"
"""The name under which the expression in the line is previewed; no effect can have it."""

HELP = "A force per unit mass from displacement u, velocity v, time t and parameters of your own."


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
        fault, verdict = await asyncio.to_thread(check, text)
        if text == self._typed:
            self._say("bad" if fault else "good", verdict)
            if not fault:
                await self._preview(text)

    async def _preview(self, text: str) -> None:
        """Show the model with the expression, fitted, as long as it stands in the line."""
        view, name = self._session.view, name_of(text)
        if view is None or self._session.running or name in view.ladder.top.effects:
            return
        try:
            found: Drawn = await self._session.ask(tasks.preview, text)
        except Failed as failure:
            if text == self._typed:
                self._say("bad", str(failure))
            return
        if text != self._typed or self._session.view is not view:
            return
        (frame,), (says,) = found.frames.values(), found.says.values()
        self._card.props["data-preview"] = OWN
        self._say("good", f"{says['what']}. Point here to see it again.")
        run(f"bench.own({json.dumps({'frame': frame, 'says': says, 'name': name})})")

    def _say(self, kind: str, text: str) -> None:
        """Say how the expression is; one that is good can be added."""
        self._message.classes(remove="bad good faint", add=kind)
        self._message.text = text
        self._button.set_enabled(kind == "good")

    def _add(self) -> None:
        if self._button.enabled:
            text, self._field.value = self._typed, ""
            self._session.change(f"Adding {name_of(text)}", refining.add, text)


def check(text: str) -> tuple[bool, str]:
    """Tell whether an expression is wrong, and a sentence: what is wrong, or what was understood."""
    if "=" not in text:
        return True, f"Give it a name first, as {EXAMPLE}"
    try:
        effect = parsed_effect(text)
    except ValueError as error:
        return True, begun(str(error))
    if any(effect.name == other.name for other in LIBRARY):
        return True, f"{effect.name} is in the library already; choose another name for your own"
    names = ", ".join(parameter.name for parameter in effect.parameters)
    return False, f"Understood: the force {effect.equation}, to be fitted: {names}"
