"""How long the operator of the workbench waits: page, preview, Add, diagnosis; clicks in a real browser."""

import os
import statistics
import time

from bench.workbench_server import admitted, browser, workbench

TITLE = "The workbench"

CLOCK = """() => { window.clock = (kind, counts, done) => { window.clocked = new Promise(tell => {
  const heard = event => {
    if (!counts(event.target)) return;
    document.removeEventListener(kind, heard, true);
    const painted = () => requestAnimationFrame(() => requestAnimationFrame(() =>
      done() ? tell(performance.now() - event.timeStamp) : painted()));
    painted();
  };
  document.addEventListener(kind, heard, true);
}) } }"""
"""Milliseconds from the moment that the browser was told of the mouse until the frame with its effect is drawn."""

PREVIEW = """name => clock("mousemove", at => at.closest("[data-preview]")?.dataset.preview === name,
  () => bench.state.pointed === name && bench.shown() === bench.state.frames[bench.state.suspects[name]]
    && document.querySelector("#ghost-step.shown .value").textContent === bench.state.says[name].times)"""
"""The maps, the residual and the ghost bar of a suspect."""

ANOTHER = """() => { const said = () => JSON.stringify([bench.state.steps, bench.state.present]), before = said();
  const steps = () => [...document.querySelectorAll(".step")];
  clock("click", () => true, () => said() !== before && steps().length === bench.state.steps.length
    && steps().findIndex(step => step.classList.contains("present")) === bench.state.present) }"""
"""Another model's curve and map, and the ladder with its step."""

READY = "!document.querySelector('[inert]') && bench.chart?.('traces')?.getOption()?.series?.length"
FIRST = "bench.state.suspects[document.querySelector('button.card-suspect').dataset.preview]"
ALL = "document.querySelector('button.card-suspect[data-preview=measured_curve]')"

SEEN = 4
"""Cards that are in view."""

PAUSE_MS = 300
"""Between two actions, as a person has it."""


def run(quick: bool) -> str:
    """Return the section of the benchmark page."""
    repetitions = 3 if quick else 12
    with workbench() as printed, browser() as started:
        page, address = admitted(started, printed, viewport={"width": 1280, "height": 720})
        page.set_default_timeout(90_000)
        page.goto(f"{address}/?session=mystery_7")
        page.wait_for_function(READY)
        page.evaluate(CLOCK)
        before = time.perf_counter()
        page.get_by_role("button", name="Diagnose", exact=True).click()
        page.wait_for_selector("button.card-suspect")
        diagnosis = time.perf_counter() - before
        page.wait_for_function(FIRST)
        page.wait_for_function(ALL)
        previews_ready = time.perf_counter() - before
        previews = [_pointed(page, number) for number in range(4 * repetitions)]
        adds, backs = [], []
        for _ in range(repetitions):
            adds.append(_until_drawn(page, page.get_by_role("button", name="Add Stribeck friction")))
            backs.append(_until_drawn(page, page.locator(".step").first))
            page.locator("button.card-suspect").first.click()  # back at a step nothing is selected
        opened = []
        for _ in range(repetitions):
            before = time.perf_counter()
            page.goto(f"{address}/?session=mystery_7")
            page.wait_for_function(READY)
            opened.append(time.perf_counter() - before)
    rows = [
        ("pointing at a suspect to its picture", previews, "0.1 s"),
        ("click on Add to the new step and its curve", adds, "1 s"),
        ("click on a step to its curve", backs, "1 s"),
        ("address to all pictures, session known", opened, ""),
    ]
    return "\n".join(_table(rows, (diagnosis, previews_ready), repetitions))


def _table(rows, found: tuple[float, float], repetitions: int) -> list[str]:
    lines = ["| what | median | slowest | wanted |", "|---|---:|---:|---:|"]
    lines += [
        f"| {what} | {statistics.median(found):.2f} s | {max(found):.2f} s | {wanted} |"
        for what, found, wanted in rows
    ]
    diagnosis, previews_ready = found
    lines.append(f"| Diagnose to the cards | {diagnosis:.1f} s | | 5 s |")
    lines.append(f"| Diagnose to all previews | {previews_ready:.1f} s | | |")
    load = os.getloadavg()[0] / (os.cpu_count() or 1)
    return [
        *lines,
        "",
        f"{repetitions} clicks and {4 * repetitions} suspects in Chromium without a graphics card, from the mouse's event to the "
        f"drawn frame; load {load:.1f} a core.",
    ]


def _pointed(page, number: int) -> float:
    """Return the seconds from pointing at a suspect until it is previewed."""
    page.wait_for_function(READY)
    cards = page.locator("button.card-suspect:not(.own)")
    card = cards.nth(number % min(SEEN, cards.count()))
    box = card.bounding_box()
    page.mouse.move(640, 5)
    page.wait_for_timeout(PAUSE_MS)
    page.evaluate(PREVIEW, card.get_attribute("data-preview"))
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    return page.evaluate("window.clocked") / 1e3


def _until_drawn(page, target) -> float:
    """Return the seconds from a click until another model is on the stage and on the ladder."""
    target.wait_for()
    page.wait_for_function(READY)
    page.wait_for_timeout(PAUSE_MS)
    page.evaluate(ANOTHER)
    target.click()
    return page.evaluate("window.clocked") / 1e3
