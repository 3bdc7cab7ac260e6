"""Pictures of a record that allows no analysis: its channels as they were recorded."""

import json
from dataclasses import asdict

from nicegui import ui

from station.workbench.session_state import SessionState
from station.workbench.widgets import run
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
            for number, trace in enumerate(traces):
                host = ui.element("div").classes("plot raw-plot").props("role=img")
                host.props["data-plot"] = f"raw{number}"
                host.props["aria-label"] = f"{trace.channel} as it was recorded"
            run(f"bench.raw({json.dumps([asdict(trace) for trace in traces])})")
