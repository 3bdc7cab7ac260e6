"""One recording with all tabs: written into the session, opened from there."""

from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb

from station.identification import Identification
from station.views import alignment, capture, log, restoring_force, results, wavelet

APPLICATION = "free-decay-station"

TABS = (capture, alignment, wavelet, restoring_force, results)
NAMES = ("Capture", "Alignment", "Wavelet", "Restoring force", "Results")


def write(file: Path, name: str, result: Identification) -> None:
    """Write the recording with its blueprint to `file`."""
    stream = rr.RecordingStream(APPLICATION, send_properties=False)
    stream.save(file, default_blueprint=blueprint(result))
    _fill(stream, name, result)


def send(url: str, name: str, result: Identification) -> None:
    """Send the same recording to a viewer that is open already."""
    stream = rr.RecordingStream(APPLICATION, send_properties=False)
    stream.connect_grpc(url, default_blueprint=blueprint(result))
    _fill(stream, name, result)


def _fill(stream: rr.RecordingStream, name: str, result: Identification) -> None:
    for tab in TABS:
        tab.write(stream, name, result)
    stream.flush()
    stream.disconnect()


def blueprint(result: Identification, active: str = "Results") -> rrb.Blueprint:
    """Return the layout: one named tab for each step of the story."""
    tabs = [tab.tab(result) for tab in TABS]
    return rrb.Blueprint(
        rrb.Tabs(*tabs, active_tab=NAMES.index(active)),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=log.TIMELINE),
        auto_views=False,
        auto_layout=False,
    )
