"""The suspects: what the model may lack, in order, each with the force that it would add."""

from functools import partial

from nicegui import ui

from station.results.diagnosis_document import DiagnosisDocument, SuspectDocument
from station.text.diagnosis_text import foretells, foretold_parts, headline, not_told_apart, shown_suspects
from station.text.layout import sentence
from station.text.numbers import evidence, probability, three_figures, typeset, with_unit
from station.workbench import view_models, widgets
from station.workbench.session_state import SessionState
from station.workbench.small_pictures import disc, reach_of
from station.workbench.theme import Theme

FORETELLS = {
    "no": "foretells no better than the model does",
    "nearly": "foretells nearly as well as the one named",
    "undecided": "foretells it, and so do others: not told apart",
}


class SuspectsPanel:
    """Diagnose, and what it found."""

    def __init__(self, session: SessionState) -> None:
        self._session = session
        self._shown: object = None
        self._places: dict[str, tuple[ui.element, bool]] = {}

    def build(self) -> None:
        """Make the panel."""
        with widgets.line():
            with ui.element("div").classes("grow"):
                widgets.head("What is missing?")
            self._ask = widgets.button("Diagnose", self._diagnose, strong=True)
        self._body = ui.element("div").props("aria-live=polite")

    def _diagnose(self) -> None:
        self._session.start("Trying every effect", "diagnose", long=True)

    def show(
        self, view: view_models.View, force_maps: dict[str, view_models.ForceMap], colours: Theme
    ) -> None:
        """Show the last diagnosis, or that there is none; what stands there already is not sent again."""
        document = view.diagnosis
        now = (document, force_maps, colours)
        if now != self._shown:
            self._shown = now
            self._body.clear()
            self._places.clear()
            with self._body:
                self._fill(view, force_maps, colours)
        if document is not None:
            self._offer(document, view)

    def _fill(
        self, view: view_models.View, force_maps: dict[str, view_models.ForceMap], colours: Theme
    ) -> None:
        document = view.diagnosis
        if document is None:
            widgets.label(
                "Diagnose tries every effect it knows on this recording, and asks what chance alone would do.",
                "small faint",
            )
            return
        self._about = widgets.label("", "small faint wrap")
        self._verdict(document)
        self._discs(document, view, force_maps, colours)
        self._next(document)

    def _offer(self, document: DiagnosisDocument, view: view_models.View) -> None:
        """Say which model was asked about, and offer what is not in the present one."""
        asked, present = document.model.effects, view.ladder.top.effects
        words = " + ".join(_plain(name) for name in asked)
        self._about.text = f"These were the suspects for {words}; Diagnose asks about the model below."
        self._about.set_visibility(asked != present)
        for name, (place, claimed) in self._places.items():
            place.clear()
            with place:
                if name in present:
                    widgets.label("in the model", "small good")
                else:
                    does = partial(self._add, name)
                    widgets.button("Add", does, f"Add {_plain(name)}", strong=claimed)

    def _verdict(self, document: DiagnosisDocument) -> None:
        good = document.verdict == "nothing_missing"
        with ui.element("div").classes(f"verdict {'good' if good else 'bad'}"):
            widgets.label(_plain(headline(document)), "strong wrap")
            widgets.label(typeset(document.explanation), "small wrap")
            foretold = foretold_parts(document)
            if foretold:
                widgets.label(_plain(sentence(foretold)), "small wrap")
            if document.rivals:
                widgets.label(_plain(sentence(not_told_apart(document))), "small wrap strong")
            for finding in document.findings:
                widgets.label(f"Sensor: {finding.title}; {finding.what_to_do}", "small wrap bad")

    def _discs(
        self,
        document: DiagnosisDocument,
        view: view_models.View,
        force_maps: dict[str, view_models.ForceMap],
        colours: Theme,
    ) -> None:
        reach = reach_of(force_maps)
        residual = force_maps.get("")
        if residual is not None and document.suspects:
            with ui.element("div").classes("suspect"):
                widgets.svg(disc(residual, reach, colours))
                with ui.element("div"):
                    widgets.label("The missing force itself", "strong")
                    widgets.label(
                        "over displacement (right) and velocity (up); orange and blue are its two directions. The "
                        "right suspect looks like it.",
                        "small faint",
                    )
        for suspect in shown_suspects(document):
            self._suspect(document, suspect, view, force_maps.get(suspect.effect), reach, colours)

    def _suspect(
        self,
        document: DiagnosisDocument,
        suspect: SuspectDocument,
        view: view_models.View,
        found: view_models.ForceMap | None,
        reach: float,
        colours: Theme,
    ) -> None:
        name = suspect.effect
        with ui.element("div").classes("suspect" + ("" if suspect.claimed else " weak")):
            if found is None:
                ui.element("div")
            else:
                widgets.svg(disc(found, reach, colours))
            widgets.label(_plain(name), "strong wrap")
            self._places[name] = (ui.element("div"), suspect.claimed)
            with ui.element("div").classes("details"):
                widgets.label(view.equations.get(name, suspect.title), "mono")
                values = [f"{p} = {typeset(with_unit(value))}" for p, value in suspect.parameters.items()]
                widgets.label(", ".join(values), "small wrap")
                widgets.label(
                    f"would leave {three_figures(suspect.motion_percent)} % of the motion, chi2 "
                    f"{three_figures(suspect.error_after)}; {_sure(document, suspect)}",
                    "small faint wrap",
                )
                if suspect.confusable_with:
                    close = _plain(", ".join(suspect.confusable_with[:4]))
                    widgets.label(f"easily confused with {close}", "small faint wrap")

    def _add(self, name: str) -> None:
        self._session.start(f"Adding {_plain(name)}", "add", name)

    def _next(self, document: DiagnosisDocument) -> None:
        with ui.element("div").style("padding-top:6px"):
            widgets.label("Record next", "small strong")
            widgets.label(document.next_experiment, "small wrap")


def _sure(document: DiagnosisDocument, suspect: SuspectDocument) -> str:
    where = f"in the {suspect.channel}; " if suspect.channel else ""
    if document.confirmation is not None and suspect.confirmed is not None:
        return where + FORETELLS.get(
            foretells(document, suspect), f"confirmed on {foretells(document, suspect)}"
        )
    return f"{where}evidence {evidence(suspect.evidence)}; by chance: p = {probability(suspect.p_value)}"


def _plain(name: str) -> str:
    return name.replace("_", " ")
