"""Rerun's viewer within the page: its files and a session's recording, served from here so that the guard's policy holds."""

from pathlib import Path
from urllib.parse import quote

from fastapi import FastAPI
from starlette.responses import FileResponse, HTMLResponse, PlainTextResponse, Response

from station.operations.identifying import VIEW
from station.workbench.session_list import SessionList

TYPES = {
    "index.html": "text/html",
    "re_viewer.js": "text/javascript",
    "re_viewer_bg.wasm": "application/wasm",
    "favicon.ico": "image/x-icon",
}
PLACE = "/viewer"
WITH_COOKIE = (
    "<script>const ask = window.fetch; "
    "window.fetch = (what, how) => ask(new Request(what, {...how, credentials: 'same-origin'}))</script>"
)
"""The viewer asks for a recording without cookies, and so without the token that the guard wants to see."""


def address_of(key: str, stamp: int, host: str, *, dark: bool = True) -> str:
    """Return the address of the viewer with a session's recording open; `stamp` keeps browsers from an old one."""
    recording = f"http://{host}{PLACE}/recording/{stamp}/{quote(key, safe='')}.rrd"
    return f"{PLACE}/index.html?url={quote(recording, safe='')}&hide_welcome_screen=1&theme={'dark' if dark else 'light'}"


def serve_viewer(app: FastAPI, folder: Path, session_list: SessionList) -> None:
    """Let the application serve the viewer's files out of `folder`, and the recordings of sessions on offer."""

    @app.get(f"{PLACE}/recording/{{stamp}}/{{name}}")
    def recording(stamp: int, name: str) -> Response:
        session = session_list.folder_of(name.removesuffix(".rrd"))
        file = None if session is None else session / "results" / VIEW
        if file is None or not file.is_file() or file.is_symlink():
            return PlainTextResponse("no such recording\n", 404)
        return FileResponse(file, media_type="application/octet-stream")

    @app.get(f"{PLACE}/{{name}}")
    def part(name: str) -> Response:
        if name not in TYPES or not (folder / name).is_file():
            return PlainTextResponse("no such file\n", 404)
        if name == "index.html":
            page = (folder / name).read_text(encoding="utf-8").replace("<head>", f"<head>{WITH_COOKIE}", 1)
            return HTMLResponse(page)
        return FileResponse(folder / name, media_type=TYPES[name])
