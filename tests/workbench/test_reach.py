"""Who can use the page: with the keyboard alone, in both colour schemes, on small and large screens."""

import re

import pytest

RULES = {"runOnly": ["wcag2a", "wcag2aa"], "rules": {"nested-interactive": {"enabled": False}}}
"""Quasar's upload puts the file's input into a button, which no page can change."""

SIZES = ((820, 1180), (1280, 720), (1920, 1080))


def boxes(located):
    return [one.bounding_box() for one in located.all()]


def tab_to(page, wanted, most=200):
    """Press Tab until the focus is on an element whose name matches."""
    name = "(document.activeElement.getAttribute('aria-label') || document.activeElement.innerText || '')"
    for _ in range(most):
        page.keyboard.press("Tab")
        if re.search(wanted, page.evaluate(name)):
            return
    raise AssertionError(f"the keyboard does not reach {wanted}")


def is_usable_on_every_screen(page):
    """Look at the page in both colour schemes; it keeps the rules of access."""
    axe = pytest.importorskip(
        "axe_playwright_python.sync_playwright", reason="axe-core is not installed here"
    ).Axe()
    for dark in (False, True):
        for width, height in SIZES[1:2] if dark else SIZES:
            page.set_viewport_size({"width": width, "height": height})
            page.wait_for_timeout(300)
            assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
            header = page.locator(".bench-head button:visible, .bench-head .q-tab")
            assert all(box["height"] <= 46 and box["x"] + box["width"] <= width for box in boxes(header))
            for name in ("map", "traces"):
                box = page.locator(f"[data-plot={name}]").bounding_box()
                assert min(box["width"], box["height"]) >= 90, (name, width)
            if width == SIZES[-1][0]:
                continue  # wider it shows no more than before
            found = axe.run(page, options=RULES)
            told = [
                (v["id"], v["description"], [n["html"][:150] for n in v["nodes"]])
                for v in found.response["violations"]
            ]
            assert not told, (width, dark, told)
        page.get_by_role("button", name="Switch between light and dark").click()
        page.wait_for_selector("body.body--dark" if not dark else "body:not(.body--dark)")


def film_keeps_its_place_and_its_scales(page):
    """Go back to step 0, while further pictures come; return the address, which has the step."""
    scales = """(() => { const [map, traces] = ["map", "traces"].map(n => bench.chart(n).getOption());
      return JSON.stringify([bench.state.reach, traces.yAxis[1].max, map.xAxis[0].max, map.visualMap[0].max]) })()"""
    at_floor = page.evaluate(scales)
    page.locator("#film").focus()
    page.keyboard.press("ArrowLeft")
    page.get_by_text("looking at step 0").wait_for()
    assert page.evaluate(scales) == at_floor
    address = page.url
    assert address.endswith("step=0")
    again = """({present}) => { const s = bench.state;
      bench.own({frame: s.frames[s.steps[0]], says: s.says.step0, name: "own"});
      bench.receive({steps: [...s.steps], present, busy: false, suspects: {}, says: {...s.says}, names: {}});
      return [s.film, s.suspects["(own)"] ?? null] }"""
    assert page.evaluate(again, {"present": 1}) == [0, "(own)"]
    assert page.evaluate(again, {"present": 0}) == [None, None]  # another model: the film starts from it
    return address


@pytest.mark.slow
def test_the_keyboard_leads_to_the_report_on_every_screen_and_an_address_and_undo_lead_back(visit, bench):
    page = visit.page
    bench.fresh("mystery_7", "keys")
    page.goto(bench.address)
    page.wait_for_selector(".session")
    tab_to(page, "^keys")
    page.keyboard.press("Enter")
    page.wait_for_url(re.compile("session=keys"))
    page.wait_for_selector(".step")
    tab_to(page, "^Diagnose")
    page.keyboard.press("Enter")
    page.wait_for_selector("button.card-suspect")
    page.wait_for_function("Object.keys(bench.state.suspects).length >= 3")
    page.wait_for_function("!document.querySelector('[inert]')")
    is_usable_on_every_screen(page)
    tab_to(page, "^Select .*would explain")
    before = page.evaluate("bench.state.pointed")
    assert before is not None  # the focus previews, as the pointer does
    page.keyboard.press("ArrowRight")
    assert page.evaluate("bench.state.pointed") != before
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("Enter")
    page.keyboard.press("Shift+Tab")
    tab_to(page, "^Add Stribeck friction")
    page.keyboard.press("Enter")
    page.get_by_text("At the noise floor").wait_for()
    page.wait_for_function("!document.querySelector('[inert]')")
    tab_to(page, "^Write the report of this model")
    page.keyboard.press("Enter")
    report = page.get_by_role("link", name="Open the report")
    report.wait_for()
    text = page.request.get(bench.address + report.get_attribute("href")).text()
    assert "coulomb" in text.lower()
    assert "http://" not in text.replace("http://www.w3.org", "")
    page.wait_for_function("!document.querySelector('[inert]')")
    page.goto(film_keeps_its_place_and_its_scales(page))
    page.get_by_text("looking at step 0").wait_for()
    report.wait_for()
    page.get_by_role("button", name="Undo the last change").click()
    page.wait_for_function("document.querySelectorAll('.step').length == 1")
