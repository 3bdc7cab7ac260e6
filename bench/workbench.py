"""How long the operator of the workbench waits: page, Add, diagnosis; clicks in a real browser."""

import os
import statistics
import time

from bench.workbench_server import admitted, browser, workbench

TITLE = "The workbench"

DRAWN = """([name, before]) => {
  const el = document.querySelector(`[data-name=${name}]`);
  return el && JSON.stringify(getElement(Number(el.id.slice(1))).chart.getOption().series[0].data[500]) !== before }"""
POINT = """name => JSON.stringify(getElement(Number(document.querySelector(`[data-name=${name}]`).id.slice(1)))
  .chart.getOption().series[0].data[500])"""


def run(quick: bool) -> str:
    """Return the section of the benchmark page."""
    repetitions = 3 if quick else 12
    with workbench() as printed, browser() as started:
        page, address = admitted(started, printed, viewport={"width": 1280, "height": 720})
        page.set_default_timeout(90_000)
        page.goto(f"{address}/?session=mystery_7")
        page.wait_for_selector("[data-name=energy] canvas")
        before = time.perf_counter()
        page.get_by_role("button", name="Diagnose").click()
        page.wait_for_selector(".suspect button")
        diagnosis = time.perf_counter() - before
        adds, backs = [], []
        for _ in range(repetitions):
            adds.append(_until_drawn(page, page.get_by_role("button", name="Add stribeck friction")))
            backs.append(_until_drawn(page, page.locator(".rung").first))
        opened = []
        for _ in range(repetitions):
            before = time.perf_counter()
            page.goto(f"{address}/?session=mystery_7")
            page.wait_for_selector("[data-name=energy] canvas")
            opened.append(time.perf_counter() - before)
    rows = [
        ("click on Add to the new curve, 8 s session, warm", adds, "1 s"),
        ("click on a rung to its curve", backs, "1 s"),
        ("address to all pictures, session known", opened, ""),
    ]
    lines = ["| what | median | slowest | wanted |", "|---|---:|---:|---:|"]
    lines += [
        f"| {what} | {statistics.median(found):.2f} s | {max(found):.2f} s | {wanted} |"
        for what, found, wanted in rows
    ]
    lines.append(f"| Diagnose to the suspects | {diagnosis:.1f} s | | |")
    load = os.getloadavg()[0] / (os.cpu_count() or 1)
    lines += [
        "",
        f"{repetitions} clicks in Debian's Chromium on the cores that compute, which had {load:.1f} times the work "
        "that they can do at once (1 or less: a computer of one's own).",
    ]
    return "\n".join(lines)


def _until_drawn(page, target) -> float:
    """Return the seconds from a click until the residual's curve has changed."""
    target.wait_for()
    page.wait_for_function("!document.querySelector('[inert]')")
    before = page.evaluate(POINT, "residual")
    clicked = time.perf_counter()
    target.click()
    page.wait_for_function(DRAWN, arg=["residual", before], polling=20)
    return time.perf_counter() - clicked
