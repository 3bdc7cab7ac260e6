"""Tabs sent to a viewer that is open."""

import rerun as rr

from station.views import log
from station.views.show import APPLICATION
from station.views.tab import Tab


def send(url: str, name: str, tabs: tuple[Tab, ...], timeline: str) -> None:
    """Send tabs to a viewer that is open already, the first in front; what went there under the same name stays."""
    stream = rr.RecordingStream(APPLICATION, recording_id=name, send_properties=False)
    stream.connect_grpc(url)
    layout = log.blueprint([tab.layout() for tab in tabs], timeline, follow=True)
    stream.send_blueprint(layout, make_active=True, make_default=True)
    for tab in tabs:
        tab.write(stream)
    stream.flush()
    stream.disconnect()
