"""One recording with all tabs: written into the session, opened from there."""

from functools import partial
from pathlib import Path

import rerun as rr

from station.story.identification import Identification
from station.views import log, restoring_force, tabs
from station.views.figure import inked
from station.views.log import Tab
from station.views.palette import VIEWERS

APPLICATION = "free-decay-station"

TABS = (tabs.capture, tabs.alignment, tabs.wavelet, restoring_force.tab, tabs.results)
RESULTS = len(TABS) - 1


def write(
    file: Path, name: str, result: Identification, more: tuple[Tab, ...] = (), *, dark: bool = True
) -> None:
    """Write the tabs with their layout to `file`, for a dark or a light viewer; `more` are further tabs."""
    stream = rr.RecordingStream(APPLICATION, send_properties=False)
    stream.save(file)
    _fill(stream, (*_tabs(name, result), *more), RESULTS, dark)


def send(url: str, name: str, result: Identification) -> None:
    """Send the same tabs to a viewer that is open already."""
    stream = rr.RecordingStream(APPLICATION, send_properties=False)
    stream.connect_grpc(url)
    _fill(stream, _tabs(name, result), RESULTS)


def send_tab(url: str, name: str, tab: Tab) -> None:
    """Send one tab alone to a viewer that is open already; what went there under the same name stays."""
    stream = rr.RecordingStream(APPLICATION, recording_id=name, send_properties=False)
    stream.connect_grpc(url)
    _fill(stream, (tab,))


def _tabs(name: str, result: Identification) -> tuple[Tab, ...]:
    return tuple(partial(tab, name=name, result=result) for tab in TABS)


def _fill(stream: rr.RecordingStream, shown: tuple[Tab, ...], active: int = 0, dark: bool = True) -> None:
    """Log tabs, lay them out with one in front, and end the stream."""
    look = VIEWERS[dark]
    with inked(look):
        layout = log.blueprint([tab(stream, look) for tab in shown], active=active)
    stream.send_blueprint(layout, make_active=True, make_default=True)
    stream.flush()
    stream.disconnect()
