"""The suspects as cards under the maps: pointing at one previews it, a click selects it, Add puts it into the model."""

from nicegui import ui

from identify.formatting import plain_name
from station.results.diagnosis_document import DiagnosisDocument
from station.story.residual import explained_words
from station.text.diagnosis_text import confirmed_by, found_in_sensor, not_distinguishable
from station.text.layout import sentence
from station.text.numbers import typeset
from station.workbench import view_models, widgets
from station.workbench.frame_store import MEASURED_CURVE
from station.workbench.others_menu import OthersMenu
from station.workbench.own_card import OwnCard
from station.workbench.session_list import SessionList
from station.workbench.session_state import SessionState
from station.workbench.worker import Cancelled, Failed, Job


class CardsPanel:
    """What the present model may lack."""

    def __init__(self, session: SessionState, session_list: SessionList) -> None:
        self._session = session
        self._others = OthersMenu(session, session_list)
        self._shown: object = None
        self._own = OwnCard(session)

    def build(self) -> None:
        """Make the panel."""
        with ui.element("section").classes("suspects").props('aria-label="Suspects"'):
            with widgets.line("suspects-head"):
                self._head = widgets.label("", "strong wrap grow verdict").props("aria-live=polite")
                self._add_it = widgets.button("Add", lambda: None, strong=True).props("id=add-selected")
                self._add_it.on(
                    "click", lambda e: self._add(e.args), js_handler="() => emit(bench.state.selected)"
                )
                self._ask = widgets.button("Diagnose", self._diagnose, strong=True)
                self._more = ui.element("div")
                self._reveal = widgets.button("Reveal the mystery", self._say_hidden)
                self._others.build()
                self._again = widgets.button("Diagnose again", self._diagnose)
                self._all = widgets.button(
                    "Add all",
                    lambda: self._session.start("Refining", "refine", long=True),
                    "Add all that is missing",
                )
            self._row = ui.element("div").classes("cards")
            self._own.build()

    async def _say_hidden(self) -> None:
        try:
            self._session.notice = await self._session.ask(Job(), "reveal")
        except (Cancelled, Failed) as failure:
            self._session.notice = str(failure)
        self._session.changed()

    def _diagnose(self) -> None:
        self._session.start("Trying every effect", "diagnose", self._session.others, long=True)

    def show(self, view: view_models.View) -> None:
        """Show the suspects of the present model, or that nobody has asked about it yet."""
        self._reveal.set_visibility(view.mystery)
        document = view.diagnosis if view.about_present else None
        floor = view.at_floor
        curve = self._session.frames.get(self._session.suspect_frames.get(MEASURED_CURVE, ""))
        now = (document, view.ladder.top.effects, floor, curve is not None)
        if now == self._shown:
            return
        self._shown = now
        self._head.text = _headline(document, floor)
        self._head.classes(remove="good bad", add="good" if floor else "")
        self._add_it.set_visibility(not floor and document is not None and bool(document.suspects))
        self._ask.set_visibility(not floor and document is None)
        self._again.set_visibility(not floor and document is not None)
        self._all.set_visibility(document is not None and not floor and bool(document.suspects))
        self._details(document)
        self._row.clear()
        with self._row:
            if document is not None and not floor:
                self._cards(document, view)
                if curve is not None:
                    self._card(
                        MEASURED_CURVE, "the measured curve", curve.says["words"],
                        "a spline of the residual, without a name",
                    )  # fmt: skip
            elif not floor:
                with ui.element("div").classes("invite"):
                    widgets.label(
                        "Diagnose tries every effect it knows on this recording. Each that explains something becomes a "
                        "card here.",
                        "small faint wrap",
                    )

    def _details(self, document: DiagnosisDocument | None) -> None:
        self._more.clear()
        if document is None:
            return
        with (
            self._more,
            ui.button("Why", color=None).props("dense no-caps flat padding='3px 8px'"),
            ui.menu().props("max-width=460px"),
            ui.element("div").classes("why"),
        ):
            widgets.label(typeset(document.explanation), "wrap")
            confirmed = confirmed_by(document)
            for text in (
                f"Confirmed on {confirmed}." if confirmed else "",
                sentence(not_distinguishable(document)),
            ):
                widgets.label(text, "small wrap")
            for finding in document.findings:
                widgets.label(f"Sensor: {found_in_sensor(finding, advice=True)}", "small wrap bad")
            widgets.label("Record next", "small strong")
            widgets.label(document.next_experiment, "small wrap")

    def _cards(self, document: DiagnosisDocument, view: view_models.View) -> None:
        top = view.ladder.top
        offered = [s for s in document.suspects if s.model is not None and s.effect not in top.effects]
        for suspect in offered[: view_models.MOST_CARDS]:
            name, words = suspect.effect, "no better than chance"
            if suspect.claimed:
                words = explained_words(top.error.chi2, suspect.error_after, top.chi2_std)
            equation = view.equations.get(name, suspect.title)
            self._card(name, plain_name(name), words, equation, "" if suspect.claimed else "weak")

    @staticmethod
    def _card(name: str, called: str, words: str, equation: str, classes: str = "") -> None:
        """Show a card: pointing at it previews the model with it, a click selects it."""
        card = ui.element("button").classes(f"card-suspect {classes}")
        card.props["type"] = "button"
        card.props["data-preview"] = name
        card.props["aria-label"] = f"Select {called}: {words}"
        with card:
            widgets.label(f"{called[:1].upper()}{called[1:]}", "name")
            widgets.label(words.replace("would explain", "explains"), "explains")
            widgets.label(equation, "mono equation").props["title"] = equation

    def _add(self, name: str | None) -> None:
        if name is not None:
            called = "the measured curve" if name == MEASURED_CURVE else plain_name(name)
            self._session.start(f"Adding {called}", "add", name)


def _headline(document: DiagnosisDocument | None, floor: bool) -> str:
    if floor:
        return "Nothing is missing: the residual is noise."
    if document is None:
        return "What is missing?"
    if not document.named:
        return (
            "Something is missing that has no name here."
            if document.suspects
            else typeset(document.explanation)
        )
    named = " and ".join(plain_name(name) for name in document.named)
    if document.verdict == "sensor_fault":
        return f"A sensor is at fault: {named}."
    return f"The missing effect is {named}."
