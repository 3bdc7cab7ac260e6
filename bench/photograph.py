"""Pictures of the viewer's tabs where there is no screen, for the documentation."""

import contextlib
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rerun.experimental import ViewerClient

from station.exits import Problem
from station.views.viewer import HOST, free_port, start, wait_for

PAINT_S = 12.0
SIZE = "1600x900"
ADVICE = "without a screen it needs a software Vulkan driver (Debian: mesa-vulkan-drivers, or chromium, which brings one)"
DRIVERS = (Path("/usr/share/vulkan/icd.d"), Path("/etc/vulkan/icd.d"))
BROWSERS = (Path("/usr/lib/chromium"), Path("/usr/lib/chromium-browser"), Path("/opt/google/chrome"))
BROKEN = (RuntimeError, ConnectionError, OSError, ValueError)
"""What the viewer's library raises when the viewer has gone."""


def photograph(file: Path, folder: Path) -> list[Path]:
    """Write one PNG for each tab of a recording into `folder`; return their paths in the order of the tabs."""
    folder.mkdir(parents=True, exist_ok=True)
    try:
        return _photographs(file, folder)
    except BROKEN as error:
        raise Problem(f"the viewer ended before its pictures were taken ({error}); {ADVICE}") from error


def _photographs(file: Path, folder: Path) -> list[Path]:
    pictures = []
    with _viewer() as client:
        client.open(str(file.resolve()))
        layout = client.get_blueprint().blueprint
        tabs = _tabs(layout)
        for path, name in tabs.items():
            for part in layout.values():
                if "active_tab" in part.get("ContainerBlueprint", {}):
                    part["ContainerBlueprint"]["active_tab"] = path
            client.set_blueprint(layout, of="recording")
            picture = folder / f"{name.lower().replace(' ', '_')}.png"
            picture.write_bytes(_settled(client))
            pictures.append(picture)
    return pictures


def _tabs(layout: dict[str, Any]) -> dict[str, str]:
    """Return the names of the outermost tabs, each a container or a single view, by their paths."""
    inside = {
        path: [found]
        if isinstance(found := part["ContainerBlueprint"].get("contents", []), str)
        else list(found)
        for path, part in layout.items()
        if "ContainerBlueprint" in part
    }
    inner = {f"/{one}" for contents in inside.values() for one in contents}
    for path, contents in inside.items():
        if layout[path]["ContainerBlueprint"].get("container_kind") == "Tabs" and path not in inner:
            parts = [layout.get(f"/{one}", {}) for one in contents]
            named = [part.get("ContainerBlueprint") or part.get("ViewBlueprint") or {} for part in parts]
            return {
                one: str(part.get("display_name", one)) for one, part in zip(contents, named, strict=True)
            }
    raise Problem("the recording has no tabs to take pictures of")


@contextlib.contextmanager
def _viewer() -> Iterator[ViewerClient]:
    port = free_port()
    os.environ |= _driver()
    process = start("--headless", "--port", str(port), "--window-size", SIZE, "--hide-welcome-screen")
    try:
        wait_for(port)
        yield ViewerClient.connect(f"rerun+http://{HOST}:{port}/proxy")
    finally:
        process.terminate()
        process.wait(timeout=10)


def _driver() -> dict[str, str]:
    """Return the environment in which a browser's own software Vulkan is found, where the system has no driver."""
    if any(folder.is_dir() and any(folder.iterdir()) for folder in DRIVERS):
        return {}
    for folder in BROWSERS:
        driver = folder / "vk_swiftshader_icd.json"
        if driver.is_file() and (folder / "libvulkan.so.1").is_file():
            return {"VK_ICD_FILENAMES": str(driver), "LD_LIBRARY_PATH": str(folder)}
    return {}


def _settled(client: ViewerClient) -> bytes:
    """Return the picture once three in a row are the same: what is loaded late has then been painted."""
    end = time.monotonic() + PAINT_S
    seen: list[bytes] = []
    while time.monotonic() < end:
        time.sleep(0.25)
        seen = [*seen[-2:], bytes(client.take_screenshot())]
        if len(seen) == 3 and seen[0] == seen[1] == seen[2]:
            break
    return seen[-1]
