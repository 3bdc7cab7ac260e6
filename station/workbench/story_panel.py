"""The middle: how far the model is off, one map of the force that it lacks, and measurement and model beneath it."""

import json

from nicegui import ui

from station.workbench import view_models, widgets
from station.workbench.widgets import run

MAPS = {
    "plane": "phase plane",
    "amplitude": "amplitude",
    "phase": "phase",
    "time": "time",
}
PICTURES = {
    "map": "Map of the missing force. Arrow keys walk along the decay.",
    "overlay": "Measurement and model over time. Arrow keys walk, Enter sets a cursor, plus and minus zoom.",
    "left": "Measurement less model over time, with the noise. Arrow keys walk, Enter sets a cursor, plus and minus zoom.",
}


class StoryPanel:
    """Statement, map and traces of one session; what they show is drawn in the browser."""

    def __init__(self) -> None:
        self._channels: tuple[str, ...] = ()

    def build(self) -> None:
        """Make the panel; it is empty until a session was sent."""
        with ui.element("section").classes("statement").props("id=statement aria-live=polite"):
            widgets.label("", "big")
            with ui.element("div").classes("grow"):
                widgets.label("", "what")
                widgets.label("", "more")
        with widgets.line("stage-tools"):
            widgets.label("Missing force over", "small faint")
            self._toggle(MAPS, "plane", "map")
            ui.element("span").classes("grow")
            self._choice = ui.element("div")
            fixed = ui.checkbox("fit scale", on_change=lambda e: self._choose("fitScale", bool(e.value)))
            fixed.props("dense size=xs").classes("small").tooltip(
                "The scale of what is left stays that of the first model, unless it is fitted to the present one"
            )
        with ui.element("section").classes("stage").props('aria-label="Where the model fails"'):
            for name, label in PICTURES.items():
                host = ui.element("div").classes(f"plot plot-{name}")
                host.props["data-plot"] = name
                host.props["tabindex"] = "0"
                host.props["role"] = "img"
                host.props["aria-label"] = label
        widgets.label("", "small faint readout").props("id=readout")

    def show(self, stage: view_models.Stage) -> None:
        """Offer the channels of a session."""
        channels = tuple(trace.channel for trace in stage.traces)
        if channels == self._channels:
            return
        self._channels = channels
        self._choice.clear()
        if len(channels) > 1:
            with self._choice, widgets.line():
                widgets.label("Traces of", "small faint")
                self._channel = self._toggle(dict(enumerate(channels)), None, "channel")

    def _toggle(self, options: dict[str, str] | dict[int, str], value: str | None, key: str) -> ui.toggle:
        made = ui.toggle(options, value=value, on_change=lambda e: self._choose(key, e.value))
        made.props('dense no-caps size=12px padding="1px 7px" unelevated toggle-color=primary')
        return made

    @staticmethod
    def _choose(key: str, value: object) -> None:
        run(f"bench.choose('{key}', {json.dumps(value)})")
