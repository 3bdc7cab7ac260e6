"""How long the operator of the workbench waits: page, preview, Add, diagnosis; clicks in a real browser."""

import os
import statistics
import time

from bench.workbench_server import admitted, browser, workbench

TITLE = "The workbench"

PREVIEW = """async index => {
  const cards = document.querySelectorAll("button.card-suspect"), card = cards[index % cards.length];
  const painted = () => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)));
  document.body.dispatchEvent(new MouseEvent("mouseover", {bubbles: true}));
  await painted();
  const begun = performance.now();
  card.dispatchEvent(new MouseEvent("mouseover", {bubbles: true}));
  await painted();
  while (bench.faded) await painted();
  return performance.now() - begun; }"""
"""Milliseconds from the pointer on a card until its map, its residual and its ghost are painted, the fading included."""

DRAWN = "before => bench.state.rungs.length && JSON.stringify([bench.state.rungs, bench.state.present]) !== before"
STATE = "JSON.stringify([bench.state.rungs, bench.state.present])"
READY = "!document.querySelector('[inert]') && bench.plots?.left?.names"


def run(quick: bool) -> str:
    """Return the section of the benchmark page."""
    repetitions = 3 if quick else 12
    with workbench() as printed, browser() as started:
        page, address = admitted(started, printed, viewport={"width": 1280, "height": 720})
        page.set_default_timeout(90_000)
        page.goto(f"{address}/?session=mystery_7")
        page.wait_for_function(READY)
        before = time.perf_counter()
        page.get_by_role("button", name="Diagnose", exact=True).click()
        page.wait_for_selector("button.card-suspect")
        diagnosis = time.perf_counter() - before
        page.wait_for_function("Object.keys(bench.state.suspects).length >= 3")
        previews_ready = time.perf_counter() - before
        previews = [page.evaluate(PREVIEW, i) / 1e3 for i in range(4 * repetitions)]
        adds, backs = [], []
        for _ in range(repetitions):
            adds.append(_until_drawn(page, page.get_by_role("button", name="Add Stribeck friction")))
            backs.append(_until_drawn(page, page.locator(".rung").first))
        opened = []
        for _ in range(repetitions):
            before = time.perf_counter()
            page.goto(f"{address}/?session=mystery_7")
            page.wait_for_function(READY)
            opened.append(time.perf_counter() - before)
    rows = [
        ("pointing at a suspect to its map, residual and ghost bar", previews, "0.1 s"),
        ("click on Add to the new rung and its curve, 8 s session, warm", adds, "1 s"),
        ("click on a rung to its curve", backs, "1 s"),
        ("address to all pictures, session known", opened, ""),
    ]
    return "\n".join(_table(rows, diagnosis, previews_ready, repetitions))


def _table(rows, diagnosis: float, previews_ready: float, repetitions: int) -> list[str]:
    lines = ["| what | median | slowest | wanted |", "|---|---:|---:|---:|"]
    lines += [
        f"| {what} | {statistics.median(found):.2f} s | {max(found):.2f} s | {wanted} |"
        for what, found, wanted in rows
    ]
    lines.append(f"| Diagnose to the cards | {diagnosis:.1f} s | | 5 s |")
    lines.append(f"| Diagnose to the cards' previews | {previews_ready:.1f} s | | |")
    load = os.getloadavg()[0] / (os.cpu_count() or 1)
    return [
        *lines,
        "",
        f"{repetitions} clicks in Debian's Chromium on the cores that compute, which had {load:.1f} times the work "
        "that they can do at once (1 or less: a computer of one's own).",
    ]


def _until_drawn(page, target) -> float:
    """Return the seconds from a click until another model is on the stage."""
    target.wait_for()
    page.wait_for_function(READY)
    before = page.evaluate(STATE)
    clicked = time.perf_counter()
    target.click()
    page.wait_for_function(DRAWN, arg=before, polling=20)
    return time.perf_counter() - clicked
