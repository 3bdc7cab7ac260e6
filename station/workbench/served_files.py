"""Files that the browser opens beside the page: reports, and Rerun's viewer with a session's recording.

They are served from here so that the guard's policy holds.
"""

from pathlib import Path
from urllib.parse import quote

from fastapi import FastAPI
from starlette.responses import FileResponse, HTMLResponse, PlainTextResponse, Response

from station.operations.identifying import VIEW
from station.report.write import NAME
from station.workbench.session_list import SessionList

TYPES = {
    "index.html": "text/html",
    "re_viewer.js": "text/javascript",
    "re_viewer_bg.wasm": "application/wasm",
    "favicon.ico": "image/x-icon",
}
WITH_COOKIE = (
    "<script>const ask = window.fetch; "
    "window.fetch = (what, how) => ask(new Request(what, {...how, credentials: 'same-origin'}))</script>"
)
"""The viewer asks for a recording without cookies, and so without the token that the guard wants to see."""

POLICY = "sandbox allow-modals; default-src 'none'; style-src 'unsafe-inline'; img-src data:; font-src data:"
"""A report runs no script and belongs to no origin, whoever wrote the file."""


def report_address(key: str) -> str:
    """Write the address of a session's report."""
    return f"/report/{quote(key, safe='')}"


def serve_files(app: FastAPI, viewer: Path, session_list: SessionList) -> None:
    """Let the application serve the viewer's files out of the folder `viewer`, and results of the sessions on offer."""

    @app.get("/report/{key}")
    def report(key: str) -> Response:
        file = session_list.result_of(key, NAME)
        if file is None:
            return PlainTextResponse("there is no report of this session yet\n", 404)
        return FileResponse(file, media_type="text/html", headers={"Content-Security-Policy": POLICY})

    @app.get("/viewer/recording/{stamp}/{name}")
    def recording(stamp: int, name: str) -> Response:
        file = session_list.result_of(name.removesuffix(".rrd"), VIEW)
        if file is None:
            return PlainTextResponse("no such recording\n", 404)
        return FileResponse(file, media_type="application/octet-stream")

    @app.get("/viewer/{name}")
    def part(name: str) -> Response:
        if name not in TYPES or not (viewer / name).is_file():
            return PlainTextResponse("no such file\n", 404)
        if name == "index.html":
            page = (viewer / name).read_text(encoding="utf-8").replace("<head>", f"<head>{WITH_COOKIE}", 1)
            return HTMLResponse(page)
        return FileResponse(viewer / name, media_type=TYPES[name])
