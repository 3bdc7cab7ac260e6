"""The web application: NiceGUI behind the guard, with the page, its style and its script."""

from pathlib import Path

from fastapi import FastAPI, Request
from nicegui import app as nicegui_app
from nicegui import background_tasks, ui

from station.settings import Settings
from station.workbench.app_state import AppState
from station.workbench.guard import Guard
from station.workbench.page import Page
from station.workbench.served_files import serve_files
from station.workbench.session_list import SessionList
from station.workbench.warm_up import warm_up
from station.workbench.worker import WorkerPool

STATIC = Path(__file__).parent / "static"
SCRIPTS = ("bench", "stage")
"""In the order in which they need each other."""

ICON = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32"><rect width="32" height="32" rx="6" fill="#00659e"/>'
    '<path d="M3 16C6 2 8 2 11 16s4 9 6 0 3-5 5 0 3 2 7 0" fill="none" stroke="#fff" stroke-width="2"/></svg>'
)


def make(
    settings: Settings,
    named: tuple[Path, ...],
    names: frozenset[str],
    token: str,
    any_address: bool,
    temporary: Path,
) -> tuple[FastAPI, AppState]:
    """Return the application and the state behind it; `names` are the hosts by which it may be called, with `token`."""
    workers = WorkerPool(settings)
    state = AppState(settings, workers, SessionList(settings.sessions, named), temporary)
    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    app.add_middleware(Guard, names=names, token=token, any_address=any_address)
    nicegui_app.add_static_files("/static/bench", STATIC)
    serve_files(app, temporary, state.session_list)
    nicegui_app.on_startup(lambda: background_tasks.create(workers.warm(warm_up)))

    @ui.page("/")
    def page(request: Request, session: str | None = None, step: int | None = None) -> None:
        ui.add_head_html('<link rel="stylesheet" href="/static/bench/bench.css">')
        for name in SCRIPTS:
            ui.add_head_html(f'<script src="/static/bench/{name}.js"></script>')
        ui.colors(primary="#00659e")
        Page(state, session, request.headers["host"], step)

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
