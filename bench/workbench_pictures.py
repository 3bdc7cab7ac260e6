"""`python -m bench.workbench_pictures`: the pictures of docs/workbench.md, taken of the page itself."""

import sys
from pathlib import Path

from bench.workbench import ALL
from bench.workbench_server import ROOT, admitted, browser, workbench

PICTURES = ROOT / "docs" / "pictures"
SIZE = {"width": 1280, "height": 720}


def main(folder: Path) -> None:
    """Walk through a mystery, light, then look at the end of it, dark."""
    with workbench() as printed, browser(webgl=True) as started:
        page, address = admitted(started, printed, viewport=SIZE, color_scheme="light")
        page.set_default_timeout(90_000)
        page.goto(address)
        page.wait_for_function("document.querySelectorAll('.session polyline[points*=\" \"]').length == 3")
        page.wait_for_timeout(1500)
        _keep(page, folder / "workbench_empty.png")
        page.goto(f"{address}/?session=mystery_7")
        page.wait_for_selector(".step")
        page.wait_for_timeout(1000)
        page.get_by_role("button", name="Diagnose", exact=True).click()
        page.wait_for_timeout(900)
        _keep(page, folder / "workbench_busy.png")
        page.wait_for_selector("button.card-suspect")
        page.wait_for_function(ALL)
        page.wait_for_function("!document.querySelector('[inert]')")
        page.mouse.move(640, 5)
        page.wait_for_timeout(800)
        _keep(page, folder / "workbench_plane.png")
        for number, name in ((0, "suspects"), (2, "wrong")):
            page.locator("button.card-suspect").nth(number).hover()
            page.wait_for_timeout(600)
            _keep(page, folder / f"workbench_{name}.png")
        page.get_by_role("button", name="Add Stribeck friction").click()
        page.wait_for_function("document.querySelectorAll('.step').length == 2")
        page.mouse.move(640, 5)
        page.wait_for_timeout(1200)
        _keep(page, folder / "workbench_floor.png")
        page.locator(".step").first.click()
        page.wait_for_selector(".step.above")
        dark, _ = admitted(started, printed, viewport={"width": 1920, "height": 1080}, color_scheme="dark")
        dark.goto(f"{address}/?session=mystery_7")
        dark.wait_for_selector("button.card-suspect")
        dark.wait_for_function(ALL)
        dark.wait_for_timeout(1500)
        _keep(dark, folder / "workbench_dark.png")
        page.get_by_role("tab", name="3-D / Rerun").click()
        page.wait_for_selector("iframe.rerun")
        page.wait_for_timeout(15_000)
        page.mouse.click(640, 400)
        page.wait_for_timeout(1500)
        _keep(page, folder / "workbench_rerun.png")


def _keep(page, file: Path) -> None:
    """Write a picture with as few colours as keep it readable."""
    from io import BytesIO

    from PIL import Image

    drawn = Image.open(BytesIO(page.screenshot())).convert("RGB")
    drawn.quantize(256, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE).save(file, optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURES)
