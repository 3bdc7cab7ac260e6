"""The suspects: what the model may lack, in order, each with its fingerprint beside the residual's."""

from functools import partial
from typing import Any

from nicegui import ui

from station.text.diagnosis_text import (
    evidence,
    headline,
    indistinguishable,
    is_claimed,
    number,
    probability,
    shown_suspects,
    size,
)
from station.workbench import view_models, widgets
from station.workbench.build_view_models import pretty
from station.workbench.session_state import Desk
from station.workbench.theme import Theme
from station.workbench.thumbnail import disc, reach_of


class SuspectsPanel:
    """Diagnose, and what it found."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._shown: object = None
        self._places: dict[str, tuple[ui.element, dict[str, Any]]] = {}

    def build(self) -> None:
        """Make the panel."""
        with widgets.line():
            with ui.element("div").classes("grow"):
                widgets.head("What is missing?")
            self._ask = widgets.button("Diagnose", self._diagnose, strong=True)
        self._body = ui.element("div").props("aria-live=polite")

    def _diagnose(self) -> None:
        self._desk.start("Trying every effect", "diagnose", long=True)

    def show(self, view: view_models.View, prints: dict[str, view_models.Print], colours: Theme) -> None:
        """Show the last diagnosis, or that there is none; what stands there already is not sent again."""
        document = view.diagnosis
        now = (document, prints, colours)
        if now != self._shown:
            self._shown = now
            self._body.clear()
            self._places.clear()
            with self._body:
                self._fill(view, prints, colours)
        if document is not None:
            self._offer(document, view)

    def _fill(self, view: view_models.View, prints: dict[str, view_models.Print], colours: Theme) -> None:
        document = view.diagnosis
        if document is None:
            widgets.words(
                "Diagnose tries every effect it knows on this recording, and asks what chance alone would do.",
                "small faint",
            )
            return
        self._about = widgets.words("", "small faint wrap")
        self._verdict(document)
        self._discs(document, view, prints, colours)
        self._next(document)

    def _offer(self, document: dict[str, Any], view: view_models.View) -> None:
        """Tell which model was asked about, and offer what is not in the present one."""
        asked, present = document["model"]["effects"], view.ladder.top.effects
        words = " + ".join(_plain(name) for name in asked)
        self._about.text = f"These were the suspects for {words}; Diagnose asks about the model below."
        self._about.set_visibility(asked != present)
        for name, (place, suspect) in self._places.items():
            place.clear()
            with place:
                if name in present:
                    widgets.words("in the model", "small good")
                else:
                    does = partial(self._add, name)
                    widgets.button("Add", does, f"Add {_plain(name)}", strong=is_claimed(suspect))

    def _verdict(self, document: dict[str, Any]) -> None:
        good = document["verdict"] == "nothing_missing"
        with ui.element("div").classes(f"verdict {'good' if good else 'bad'}"):
            widgets.words(_plain(headline(document)), "strong wrap")
            widgets.words(pretty(document["explanation"]).replace("+-", "±"), "small wrap")
            rivals = indistinguishable(document)
            if rivals:
                widgets.words(
                    f"This record does not tell {_plain(document['named'][0])} from {_plain(', '.join(rivals))}.",
                    "small wrap strong",
                )
            for finding in document["findings"]:
                widgets.words(f"Sensor: {finding['title']}; {finding['what_to_do']}", "small wrap bad")

    def _discs(
        self,
        document: dict[str, Any],
        view: view_models.View,
        prints: dict[str, view_models.Print],
        colours: Theme,
    ) -> None:
        reach = reach_of(prints)
        residual = prints.get("")
        if residual is not None and document["suspects"]:
            with ui.element("div").classes("suspect"):
                widgets.svg(disc(residual, reach, colours))
                with ui.element("div"):
                    widgets.words("The missing force itself", "strong")
                    widgets.words(
                        "over displacement (right) and velocity (up); orange and blue are its two directions. The "
                        "right suspect looks like it.",
                        "small faint",
                    )
        for suspect in shown_suspects(document):
            self._suspect(suspect, view, prints.get(suspect["effect"]), reach, colours)

    def _suspect(
        self,
        suspect: dict[str, Any],
        view: view_models.View,
        found: view_models.Print | None,
        reach: float,
        colours: Theme,
    ) -> None:
        name = suspect["effect"]
        known = view.effects.get(name)
        with ui.element("div").classes("suspect" + ("" if is_claimed(suspect) else " weak")):
            if found is None:
                ui.element("div")
            else:
                widgets.svg(disc(found, reach, colours))
            widgets.words(_plain(name), "strong wrap")
            if name in view.ladder.top.effects:
                widgets.words("in the model", "small good")
            else:
                widgets.button(
                    "Add", lambda: self._add(name), f"Add {_plain(name)}", strong=is_claimed(suspect)
                )
            with ui.element("div").classes("details"):
                widgets.words(known.equation if known else suspect["title"], "mono")
                values = [f"{p} = {pretty(number(value))}" for p, value in suspect["parameters"].items()]
                widgets.words(", ".join(values), "small wrap")
                widgets.words(
                    f"chi2 would be {size(suspect['error_after'])}; {_sure(suspect)}", "small faint wrap"
                )
                if suspect["confusable_with"]:
                    close = _plain(", ".join(suspect["confusable_with"][:4]))
                    widgets.words(f"easily taken for {close}", "small faint wrap")

    def _add(self, name: str) -> None:
        self._desk.start(f"Adding {_plain(name)}", "add", name)

    def _next(self, document: dict[str, Any]) -> None:
        with ui.element("div").style("padding-top:6px"):
            widgets.words("Record next", "small strong")
            widgets.words(document["next_experiment"], "small wrap")


def _sure(suspect: dict[str, Any]) -> str:
    where = f"in the {suspect['channel']}; " if suspect["channel"] else ""
    return (
        f"{where}evidence {evidence(suspect['evidence'])}; by chance: p = {probability(suspect['p_value'])}"
    )


def _plain(name: str) -> str:
    return name.replace("_", " ")
