"""Rerun's viewer for a browser: the files that came with the SDK, so that they match it, for one's own server."""

import re
import urllib.request
from pathlib import Path

from station.exits import Problem
from station.views.viewer import HOST, START_S, free_ports, start, wait_for

FILES = ("index.html", "re_viewer.js", "re_viewer_bg.wasm", "favicon.ico")
OUTSIDE = re.compile(rb"<link\b[^>]*https?://[^>]*>")
"""Fonts from elsewhere: a policy would block the sheet, but not the connection that is opened ahead."""


def unpack(folder: Path) -> None:
    """Write the viewer's files into a folder; Problem when they cannot be had.

    The viewer holds them inside its program: it is asked to serve them on 127.0.0.1 for the moment that takes.
    """
    ports = free_ports(2)
    process = start("--serve-web", "--web-viewer-port", str(ports[0]), "--port", str(ports[1]))
    try:
        wait_for(ports[0])
        for name in FILES:
            address = f"http://{HOST}:{ports[0]}/{'' if name == 'index.html' else name}"
            with urllib.request.urlopen(address, timeout=START_S) as answer:
                content = answer.read()
            (folder / name).write_bytes(OUTSIDE.sub(b"", content) if name.endswith(".html") else content)
    except OSError as error:
        raise Problem(f"the Rerun viewer did not give its files ({error})") from error
    finally:
        process.terminate()
        process.wait(timeout=10)
