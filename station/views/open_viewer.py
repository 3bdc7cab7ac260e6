"""The viewer that a session's story is shown in: the one that is open, or a new one where there is a screen."""

import os
import socket
import time
from urllib.parse import urlsplit

from station.views.viewer import HOST, has_screen, start

PORT = 9876
VARIABLE = "STATION_VIEWER"
START_S = 20.0
PATIENCE_S = 0.3


def open_url() -> str | None:
    """Return where a viewer listens: as the environment says (STATION_VIEWER), or Rerun's own port; None if none does."""
    url = os.environ.get(VARIABLE) or f"rerun+http://{HOST}:{PORT}/proxy"
    parts = urlsplit(url)
    return url if parts.hostname and parts.port and _answers(parts.hostname, parts.port) else None


def url_or_new() -> str | None:
    """Return where a viewer listens, after starting one if a window can be opened; None where there is no screen."""
    found = open_url()
    if found is not None or not has_screen():
        return found
    start("--port", str(PORT), "--hide-welcome-screen")
    end = time.monotonic() + START_S
    while time.monotonic() < end:
        found = open_url()
        if found is not None:
            return found
        time.sleep(0.1)
    return None


def _answers(host: str, port: int) -> bool:
    try:
        socket.create_connection((host, port), timeout=PATIENCE_S).close()
    except OSError:
        return False
    return True
