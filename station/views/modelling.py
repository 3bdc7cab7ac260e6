"""Tabs sent to a viewer that is open."""

import rerun as rr
import rerun.blueprint as rrb

from station.views.show import APPLICATION
from station.views.tab import Tab


def send(url: str, name: str, tabs: tuple[Tab, ...], timeline: str) -> None:
    """Send tabs to a viewer that is open already, the first in front; what went there under the same name stays."""
    stream = rr.RecordingStream(APPLICATION, recording_id=name, send_properties=False)
    stream.connect_grpc(url)
    stream.send_blueprint(blueprint(tabs, timeline), make_active=True, make_default=True)
    for tab in tabs:
        tab.write(stream)
    stream.flush()
    stream.disconnect()


def blueprint(tabs: tuple[Tab, ...], timeline: str) -> rrb.Blueprint:
    """Return the layout: the tabs, and a time panel on which `timeline` can be stepped through."""
    return rrb.Blueprint(
        rrb.Tabs(*(tab.layout() for tab in tabs), active_tab=0),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=timeline, play_state="Following"),
        auto_views=False,
        auto_layout=False,
    )
