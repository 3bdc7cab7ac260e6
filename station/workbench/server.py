"""The server: one process on 127.0.0.1 that serves the page until it is interrupted."""

import asyncio
import html
import os
import secrets
import signal
import socket
import tempfile
import webbrowser
from pathlib import Path

from station.exits import UsageProblem
from station.output import next_line, progress, say_in_one_line
from station.settings import Settings

HOST = "127.0.0.1"


def listen(host: str, port: int) -> socket.socket:
    """Make a socket that listens; port 0 takes a free one. UsageProblem where that is not possible."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        return socket.create_server((host, port), family=family, backlog=64)
    except OSError as error:
        raise UsageProblem(
            f"{host}:{port} cannot be used ({error.strerror or error}); leave --port out for a free one"
        ) from error


def serve(
    settings: Settings,
    named: tuple[Path, ...],
    host: str,
    port: int,
    open_browser: bool,
) -> None:
    """Serve until interrupted. `named` are sessions of the command line; the first is opened."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # it tidies up as after Ctrl-C
    with listen(host, port) as opened, tempfile.TemporaryDirectory(prefix="workbench-") as temporary:
        os.environ.setdefault("NICEGUI_STORAGE_PATH", temporary)
        import uvicorn

        from station.workbench.application import make, say_stopped
        from station.workbench.session_list import address_of

        bound = opened.getsockname()[1]
        shown = HOST if host in ("0.0.0.0", "::") else host
        place = f"[{shown}]:{bound}" if ":" in shown else f"{shown}:{bound}"
        token, folder = secrets.token_urlsafe(24), Path(temporary)
        app, state = make(settings, named, token, folder)
        page = f"http://{place}{address_of(named[0].resolve().name) if named else '/'}"
        address = f"{page}{'&' if '?' in page else '?'}token={token}"
        say_in_one_line()
        config = uvicorn.Config(
            app, log_config=None, log_level="error", ws_max_size=1 << 24, timeout_graceful_shutdown=1
        )

        class Server(uvicorn.Server):
            async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
                await say_stopped()
                await super().shutdown(sockets)

        server = Server(config)

        async def run() -> None:
            progress(f"workbench: {address}")
            progress("end it with Ctrl-C")
            if open_browser:
                asyncio.get_running_loop().run_in_executor(None, webbrowser.open, _way_to(address, folder))
            await server.serve(sockets=[opened])

        try:
            asyncio.run(run())
        except KeyboardInterrupt:
            progress("workbench closed; everything is kept in the sessions")
            progress(next_line("list", settings.sessions))
        finally:
            if state.capturing is not None:
                state.capturing.cancel()
                state.capturing.wait(3.0)
            state.workers.end()


def _way_to(address: str, temporary: Path) -> str:
    """Return a page, readable by this user only, that leads to the address: every user sees a program's arguments."""
    page = temporary / "open.html"
    page.write_text(f'<meta http-equiv="refresh" content="0;url={html.escape(address)}">', encoding="utf-8")
    return page.as_uri()
