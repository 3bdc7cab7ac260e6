"""The web application: NiceGUI behind the guard, with the page, its style and script, and the files opened beside it."""

import asyncio
import logging
from pathlib import Path

from fastapi import FastAPI, Request
from nicegui import Client, app as nicegui_app, background_tasks, ui
from starlette.responses import FileResponse, HTMLResponse, PlainTextResponse, Response

from station.operations.viewer_tabs import VIEW
from station.operations.workers import WorkerPool
from station.report.write import NAME
from station.settings import Settings
from station.views.viewer import FILES
from station.workbench.guard import Guard
from station.workbench.page import Page
from station.workbench.session_list import SessionList
from station.workbench.session_state import AppState
from station.workbench.tasks import warm_up

STATIC = Path(__file__).parent / "static"

ICON = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32"><rect width="32" height="32" rx="6" fill="#00659e"/>'
    '<path d="M3 16C6 2 8 2 11 16s4 9 6 0 3-5 5 0 3 2 7 0" fill="none" stroke="#fff" stroke-width="2"/></svg>'
)

WITH_COOKIE = (
    "<script>const ask = window.fetch; "
    "window.fetch = (what, how) => ask(new Request(what, {...how, credentials: 'same-origin'}))</script>"
)
"""The viewer asks for a recording without cookies, and so without the token that the guard wants to see."""

POLICY = "sandbox allow-modals; default-src 'none'; style-src 'unsafe-inline'; img-src data:; font-src data:"
"""A report runs no script and belongs to no origin, whoever wrote the file."""


def make(
    settings: Settings, named: tuple[Path, ...], token: str, temporary: Path
) -> tuple[FastAPI, AppState]:
    """Return the application, which answers who has the `token`, and the state behind it."""
    workers = WorkerPool(settings)
    state = AppState(settings, workers, SessionList(settings.sessions, named), temporary)
    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    app.add_middleware(Guard, token=token)
    logging.getLogger("nicegui").setLevel(
        logging.ERROR
    )  # it warns of a busy computer, and of what is not served
    nicegui_app.add_static_files("/static/bench", STATIC)
    serve_files(app, temporary, state.session_list)
    nicegui_app.on_startup(lambda: background_tasks.create(workers.warm(warm_up)))

    @ui.page("/")
    def page(request: Request, session: str | None = None) -> None:
        ui.add_head_html('<link rel="stylesheet" href="/static/bench/bench.css">')
        for name in ("bench", "stage"):  # in the order in which they need each other
            ui.add_head_html(f'<script src="/static/bench/{name}.js"></script>')
        ui.colors(primary="#00659e")
        Page(state, session, request.headers["host"])

    ui.run_with(
        app,
        title="workbench",
        favicon=ICON,
        dark=None,
        show_welcome_message=False,
        tailwind=False,
        gzip_middleware_factory=None,  # the guard has to read a page to put its nonce in
        reconnect_timeout=10.0,
    )
    return app, state


async def say_stopped() -> None:
    """Tell every tab that the server ends, and NiceGUI to end in silence: what it cannot cancel ends with the process."""
    logging.getLogger("nicegui").setLevel(logging.CRITICAL)
    for client in Client.instances.values():
        client.run_javascript("bench.stopped()")
    await asyncio.sleep(0.1)  # until it is sent


def serve_files(app: FastAPI, viewer: Path, session_list: SessionList) -> None:
    """Let the application serve the viewer's files out of the folder `viewer`, and results of the sessions on offer."""

    def result(key: str, name: str, kind: str, **headers: str) -> Response:
        file = session_list.result_of(key, name)
        if file is None:
            return PlainTextResponse("this session has no such result yet\n", 404)
        return FileResponse(file, media_type=kind, headers=headers)

    @app.get("/report/{key}")
    def report(key: str) -> Response:
        return result(key, NAME, "text/html", **{"Content-Security-Policy": POLICY})

    @app.get("/viewer/recording/{stamp}/{name}")
    def recording(stamp: int, name: str) -> Response:
        return result(name.removesuffix(".rrd"), VIEW, "application/octet-stream")

    @app.get("/viewer/{name}")
    def part(name: str) -> Response:
        if name not in FILES or not (viewer / name).is_file():
            return PlainTextResponse("no such file\n", 404)
        if name == "index.html":
            page = (viewer / name).read_text(encoding="utf-8").replace("<head>", f"<head>{WITH_COOKIE}", 1)
            return HTMLResponse(page)
        return FileResponse(viewer / name, media_type=FILES[name])
