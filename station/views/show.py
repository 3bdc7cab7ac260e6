"""One recording with all tabs: written into the session, opened from there."""

from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb

from station.story.identification import Identification
from station.views import alignment, capture, log, palette, restoring_force, results, wavelet
from station.views.figure import inked
from station.views.tab import Tab

APPLICATION = "free-decay-station"

TABS = (capture, alignment, wavelet, restoring_force, results)


def write(
    file: Path, name: str, result: Identification, more: tuple[Tab, ...] = (), *, dark: bool = True
) -> None:
    """Write the recording with its blueprint to `file`, for a dark or a light viewer; `more` are further tabs."""
    palette.ground.set(palette.GROUNDS[dark])
    stream = rr.RecordingStream(APPLICATION, send_properties=False)
    stream.save(file, default_blueprint=blueprint(result, more))
    _fill(stream, name, result, more)


def send(url: str, name: str, result: Identification) -> None:
    """Send the same recording to a viewer that is open already."""
    stream = rr.RecordingStream(APPLICATION, send_properties=False)
    stream.connect_grpc(url, default_blueprint=blueprint(result))
    _fill(stream, name, result)


def send_tabs(url: str, name: str, tabs: tuple[Tab, ...]) -> None:
    """Send tabs alone to a viewer that is open already, the first in front; what went there under the same name stays."""
    stream = rr.RecordingStream(APPLICATION, recording_id=name, send_properties=False)
    stream.connect_grpc(url)
    layout = log.blueprint([tab.layout() for tab in tabs])
    stream.send_blueprint(layout, make_active=True, make_default=True)
    with inked(palette.SCREEN):
        for tab in tabs:
            tab.write(stream)
    stream.flush()
    stream.disconnect()


def _fill(stream: rr.RecordingStream, name: str, result: Identification, more: tuple[Tab, ...] = ()) -> None:
    with inked(palette.SCREEN):
        for tab in TABS:
            tab.write(stream, name, result)
        for other in more:
            other.write(stream)
    stream.flush()
    stream.disconnect()


def blueprint(result: Identification, more: tuple[Tab, ...] = ()) -> rrb.Blueprint:
    """Return the layout: one named tab for each step of the pipeline, the results in front."""
    tabs = [*(tab.tab(result) for tab in TABS), *(other.layout() for other in more)]
    return log.blueprint(tabs, active=TABS.index(results))
