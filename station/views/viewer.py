"""The viewer itself: opened on a file, found where one is open already, or its files unpacked for a browser."""

import os
import re
import socket
import subprocess
import sys
import time
import urllib.request
from importlib.util import find_spec
from pathlib import Path

from station.exits import Problem

HOST = "127.0.0.1"
PORT = 9876
START_S = 20.0
PATIENCE_S = 0.3

FILES = {
    "index.html": "text/html",
    "re_viewer.js": "text/javascript",
    "re_viewer_bg.wasm": "application/wasm",
    "favicon.ico": "image/x-icon",
}
"""Those that a browser needs, with their media types."""

OUTSIDE = re.compile(rb"<link\b[^>]*https?://[^>]*>")
"""Fonts from elsewhere: a policy would block the sheet, but not the connection that is opened ahead."""


def has_screen() -> bool:
    """Tell whether a window can be opened here."""
    if sys.platform in ("win32", "darwin"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def executable() -> str:
    """Return the path of the viewer that came with the SDK.

    The program itself, not its launcher in `bin/`: ending the launcher would leave the viewer behind.
    """
    package = find_spec("rerun_cli")
    if package is None or package.origin is None:
        raise Problem("the Rerun viewer is not installed; `pip install rerun-sdk` brings it")
    return str(Path(package.origin).with_name("rerun.exe" if sys.platform == "win32" else "rerun"))


def start(*arguments: str) -> "subprocess.Popen[bytes]":
    """Start a viewer as a process that outlives this one, listening on 127.0.0.1 only."""
    return subprocess.Popen(
        [executable(), *arguments, "--bind", HOST],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
        env=os.environ | {"RUST_LOG": "error"},
    )


def free_port() -> int:
    """Return a port of this computer on which nobody listens."""
    with socket.socket() as one:
        one.bind((HOST, 0))
        return int(one.getsockname()[1])


def answers(port: int) -> bool:
    """Tell whether a viewer listens at a port of this computer."""
    try:
        socket.create_connection((HOST, port), timeout=PATIENCE_S).close()
    except OSError:
        return False
    return True


def wait_for(port: int) -> bool:
    """Wait until a viewer that was started listens, at most `START_S` seconds; return whether it does."""
    end = time.monotonic() + START_S
    while not answers(port):
        if time.monotonic() > end:
            return False
        time.sleep(0.1)
    return True


def show(file: Path, port: int = PORT) -> None:
    """Show a recording in the viewer that listens at a port of this computer, else in a new one, which stays open."""
    start(str(file), "--port", str(port), "--hide-welcome-screen")


def unpack(folder: Path) -> None:
    """Write the viewer's files into a folder; Problem when they cannot be had.

    The viewer holds them inside its program: it is asked to serve them on 127.0.0.1 for the moment that takes.
    """
    port = free_port()
    process = start("--serve-web", "--web-viewer-port", str(port), "--port", "auto")
    try:
        wait_for(port)
        for name in FILES:
            address = f"http://{HOST}:{port}/{'' if name == 'index.html' else name}"
            with urllib.request.urlopen(address, timeout=START_S) as answer:
                content = answer.read()
            (folder / name).write_bytes(OUTSIDE.sub(b"", content) if name.endswith(".html") else content)
    except OSError as error:
        raise Problem(f"the Rerun viewer did not give its files ({error})") from error
    finally:
        process.terminate()
        process.wait(timeout=10)
