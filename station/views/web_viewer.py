"""Rerun's viewer for a browser: the files that came with the SDK, so that they match it, for one's own server."""

import re
import time
import urllib.request
from pathlib import Path

from station.exits import Problem
from station.views.viewer import HOST, free_ports, start

FILES = ("index.html", "re_viewer.js", "re_viewer_bg.wasm", "favicon.ico")
START_S = 15.0
OUTSIDE = re.compile(rb"<link\b[^>]*https?://[^>]*>")
"""Fonts from elsewhere: a policy would block the sheet, but not the connection that is opened ahead."""


def unpack(folder: Path) -> None:
    """Write the viewer's files into a folder; Problem when they cannot be had.

    The viewer holds them inside its program: it is asked to serve them on 127.0.0.1 for the moment that takes.
    """
    ports = free_ports(2)
    process = start("--serve-web", "--web-viewer-port", str(ports[0]), "--port", str(ports[1]))
    try:
        for name in FILES:
            _fetch(ports[0], name, folder / name)
    finally:
        process.terminate()
        process.wait(timeout=10)


def _fetch(port: int, name: str, file: Path) -> None:
    path = "" if name == "index.html" else name
    until = time.monotonic() + START_S
    while True:
        try:
            with urllib.request.urlopen(f"http://{HOST}:{port}/{path}", timeout=START_S) as answer:
                content = answer.read()
                file.write_bytes(OUTSIDE.sub(b"", content) if name.endswith(".html") else content)
                return
        except OSError as error:
            if time.monotonic() > until:
                raise Problem(f"the Rerun viewer did not give its files ({error})") from error
            time.sleep(0.1)
