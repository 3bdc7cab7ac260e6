"""`python -m bench.pictures`: the pictures of the documentation, taken of the page, the report and the viewer themselves.

Beside them stands of which sources they were made; a test compares, so that no picture stays when the page has changed.
"""

import hashlib
import sys
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

from bench.workbench import ALL
from bench.workbench_server import ROOT, admitted, browser, workbench

PICTURES = ROOT / "docs" / "pictures"
MADE_OF = "made_of.txt"
SOURCES = (
    "station/workbench/static/*",
    "station/workbench/parts.html",
    "station/workbench/cards_panel.py",
    "station/workbench/telling*.py",
    "station/views/tabs.py",
    "station/report/*.html",
    "station/views/*figure*.py",
    "station/report/first_page.py",
)
SIZE = {"width": 1280, "height": 720}
PAPER = {"width": 820, "height": 1130}


def fingerprint() -> str:
    """Return a checksum of the sources that decide what the pictures show."""
    found = hashlib.sha256()
    for pattern in SOURCES:
        for file in sorted(ROOT.glob(pattern)):
            found.update(file.read_bytes())
    return found.hexdigest()


def main(folder: Path) -> None:
    """Walk through a mystery, light, then look at it dark, at its report, and at the viewer."""
    with workbench() as printed, browser() as started:
        page, address = admitted(started, printed, viewport=SIZE, color_scheme="light")
        page.set_default_timeout(90_000)
        page.goto(f"{address}/?session=mystery_7")
        page.wait_for_selector(".step")
        page.wait_for_timeout(2500)
        _keep(page, folder / "workbench_plane.png")
        page.get_by_role("button", name="Diagnose", exact=True).click()
        page.wait_for_selector("button.card-suspect")
        page.wait_for_function(ALL)
        page.wait_for_function("!document.querySelector('[inert]')")
        page.mouse.move(640, 5)
        page.wait_for_timeout(800)
        _keep(page, folder / "workbench_suspects.png")
        dark, _ = admitted(started, printed, viewport={"width": 1920, "height": 1080}, color_scheme="dark")
        dark.goto(f"{address}/?session=mystery_7")
        dark.wait_for_function(ALL)
        dark.wait_for_timeout(1500)
        _keep(dark, folder / "workbench_dark.png")
        page.locator("button.card-suspect").nth(2).hover()
        page.wait_for_timeout(600)
        _keep(page, folder / "workbench_wrong.png")
        page.get_by_role("button", name="Add Stribeck friction").click()
        page.get_by_text("At the noise floor").wait_for()
        page.wait_for_function("!document.querySelector('[inert]')")
        page.mouse.move(640, 5)
        page.wait_for_timeout(1200)
        _keep(page, folder / "workbench_floor.png")
        page.get_by_role("tab", name="Curves").click()
        page.locator(".told .picture").first.wait_for()
        page.wait_for_timeout(1200)
        _keep(page, folder / "workbench_curves.png")
        page.get_by_role("button", name="Write the report of this session").click()
        report = page.get_by_role("link", name="Open the report")
        report.wait_for()
        paper, _ = admitted(started, printed, viewport=PAPER, color_scheme="light")
        paper.goto(address + (report.get_attribute("href") or ""))
        paper.wait_for_timeout(800)
        _keep(paper, folder / "report.png")
    _viewer(folder)
    (folder / MADE_OF).write_text(f"{fingerprint()}\n", encoding="ascii")


def _viewer(folder: Path) -> None:
    """Take the tabs of the viewer that the pages show."""
    from bench.photograph import photograph
    from station.operations.examples import open_example
    from station.operations.identifying import identify_session
    from station.operations.viewer_tabs import write_view
    from station.settings import Settings

    with TemporaryDirectory() as name:
        settings = Settings(sessions=Path(name) / "sessions")
        session = open_example("simulated_plain", settings.sessions)
        result, _ = identify_session(session, settings)
        for picture in photograph(write_view(session, result, settings), Path(name) / "tabs"):
            if picture.stem in ("alignment", "results"):
                (folder / picture.name).write_bytes(_small(picture.read_bytes()))


def _keep(page, file: Path) -> None:
    """Write a picture with as few colours as keep it readable."""
    file.write_bytes(_small(page.screenshot()))


def _small(content: bytes) -> bytes:
    from PIL import Image

    drawn = Image.open(BytesIO(content)).convert("RGB")
    out = BytesIO()
    drawn.quantize(256, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE).save(
        out, "png", optimize=True
    )
    return out.getvalue()


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURES)
