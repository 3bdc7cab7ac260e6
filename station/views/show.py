"""One recording with all tabs: written into the session, opened from there."""

from pathlib import Path

import rerun as rr

from station.story.identification import Identification
from station.views import log, restoring_force, tabs
from station.views.figure import inked
from station.views.palette import VIEWERS

APPLICATION = "free-decay-station"

TABS = (tabs.capture, tabs.alignment, tabs.wavelet, restoring_force.tab, tabs.results)


def write(file: Path, name: str, result: Identification, *, dark: bool = True) -> None:
    """Write the tabs with their layout to `file`, for a dark or a light viewer."""
    stream = rr.RecordingStream(APPLICATION, send_properties=False)
    stream.save(file)
    _fill(stream, name, result, dark)


def send(url: str, name: str, result: Identification) -> None:
    """Send the same tabs to a viewer that is open already."""
    stream = rr.RecordingStream(APPLICATION, send_properties=False)
    stream.connect_grpc(url)
    _fill(stream, name, result)


def _fill(stream: rr.RecordingStream, name: str, result: Identification, dark: bool = True) -> None:
    """Log the tabs, lay them out with the last in front, and end the stream."""
    look = VIEWERS[dark]
    with inked(look):
        shown = [tab(stream, look, name, result) for tab in TABS]
    stream.send_blueprint(log.blueprint(shown, active=len(TABS) - 1), make_active=True, make_default=True)
    stream.flush()
    stream.disconnect()
