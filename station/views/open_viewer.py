"""The viewer in which a session is shown: the one that is open, or a new one where there is a screen."""

import os
from urllib.parse import urlsplit

from station.views.viewer import HOST, answers, has_screen, start, wait_for

PORT = 9876
VARIABLE = "STATION_VIEWER"


def open_url() -> str | None:
    """Find where a viewer listens: as the environment says (STATION_VIEWER), or Rerun's own port; None if none does."""
    url = os.environ.get(VARIABLE) or f"rerun+http://{HOST}:{PORT}/proxy"
    parts = urlsplit(url)
    return url if parts.hostname and parts.port and answers(parts.hostname, parts.port) else None


def url_or_new() -> str | None:
    """Find where a viewer listens, after starting one if a window can be opened; None where there is no screen."""
    found = open_url()
    if found is not None or not has_screen():
        return found
    start("--port", str(PORT), "--hide-welcome-screen")
    return open_url() if wait_for(PORT) else None
