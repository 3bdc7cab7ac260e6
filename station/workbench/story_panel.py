"""The middle: how far the model is off, the force that it lacks before and after, and measurement and model over time."""

import json

from nicegui import ui

from station.workbench import view_models, widgets
from station.workbench.widgets import run

PICTURES = {
    "map": "The force that the model lacks over displacement and velocity, before and after",
    "traces": "Measurement and model over time, and the residual with the noise",
}


class StoryPanel:
    """Statement, maps and traces of one session; what they show is drawn in the browser."""

    def __init__(self) -> None:
        self._channels: tuple[str, ...] = ()

    def build(self) -> None:
        """Make the panel; it is empty until a session was sent."""
        with ui.element("section").classes("statement").props("id=statement aria-live=polite"):
            widgets.label("", "big")
            with ui.element("div").classes("grow"):
                widgets.label("", "what")
                widgets.label("", "more")
        with ui.element("section").classes("stage").props('aria-label="Where the model fails"'):
            with widgets.line("small faint"):
                widgets.label("Force that the model lacks; grey: none, or within the noise", "grow")
                self._choice = ui.element("div")
            for name, label in PICTURES.items():
                widgets.chart(name, label, f"plot-{name}")

    def show(self, stage: view_models.Stage) -> None:
        """Offer the channels of a session."""
        channels = tuple(trace.channel for trace in stage.traces)
        if channels == self._channels:
            return
        self._channels = channels
        self._choice.clear()
        if len(channels) > 1:
            with self._choice, widgets.line():
                widgets.label("below:")
                made = ui.toggle(
                    dict(enumerate(channels)),
                    on_change=lambda e: run(f"bench.choose('channel', {json.dumps(e.value)})"),
                )
                made.props('dense no-caps size=12px padding="1px 7px" unelevated toggle-color=primary')
