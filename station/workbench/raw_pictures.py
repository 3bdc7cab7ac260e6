"""Pictures of a record that allows no analysis: its channels as they were recorded."""

from nicegui import ui

from station.workbench import view_models, widgets
from station.workbench.chart_parts import Options, base_options, grid_of, line_series, value_axis
from station.workbench.session_state import SessionState
from station.workbench.theme import theme
from station.workbench.worker import Cancelled, Failed, Job


class RawPictures:
    """One picture a channel, drawn when the record has been read."""

    def __init__(self, session: SessionState) -> None:
        self._session = session

    def build(self) -> None:
        """Make the place for the pictures, and fill it."""
        self._place = ui.element("div").classes("raw")
        ui.timer(0.05, self._fill, once=True)

    async def _fill(self) -> None:
        try:
            traces = await self._session.ask(Job(), "raw")
        except (Failed, Cancelled):
            return
        with self._place:
            for trace in traces:
                name = f"{trace.channel} [{trace.unit}]"
                widgets.chart("raw", f"{trace.channel} as it was recorded", "raw-plot", _options(trace, name))


def _options(trace: view_models.RawTrace, name: str) -> Options:
    colours = theme(False)
    return base_options(colours) | {
        "grid": grid_of(bottom=36),
        "xAxis": value_axis("time since the start of the record [s]", colours, below=True),
        "yAxis": value_axis(name, colours) | {"scale": True},
        "series": [line_series(name, trace.time, trace.values, colours.left, 1.2)],
    }
