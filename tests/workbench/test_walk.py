"""A newcomer's walk with the mouse: from opening the page to the right effect and the error at the floor."""

import json
import re
import subprocess
import sys

import pytest

STAIN = """f => { const x = f.cycle.map((y, i) => y === null ? null : (y / f.cycle_std[i]) ** 2).filter(y => y !== null);
  return x.reduce((a, b) => a + b, 0) / x.length }"""


def shown(page):
    return page.evaluate(f"({STAIN})(bench.shown())")


def stain(page):
    return page.evaluate(
        f"""(() => {{ const s = bench.state, of = {STAIN}, names = Object.values(s.suspects);
        return {{model: of(s.frames[s.rungs[s.present]]), second: of(s.frames[names[1]])}} }})()"""
    )


def chi2_of_rungs(page):
    return [float(text) for text in page.locator(".rung .value").all_inner_texts()]


def test_a_newcomer_finds_the_hidden_effect_and_reaches_the_floor(visit, bench):
    page = visit.page
    bench.fresh("mystery_7", "walk")
    page.goto(bench.address)
    page.get_by_role("link", name=re.compile("walk")).click()
    page.wait_for_selector(".rung")
    before = chi2_of_rungs(page)
    assert len(before) == 1
    assert before[0] > 10
    page.get_by_role("button", name="Diagnose").click()
    page.wait_for_selector("button.card-suspect")
    assert "Stribeck friction" in page.locator(".verdict").inner_text()
    page.wait_for_function("Object.keys(bench.state.suspects).length >= 3")
    left = stain(page)
    assert (
        left["model"] > 5
    )  # mean square of the missing force in units of its noise, cell by cell; noise has 1
    cards = page.locator("button.card-suspect")
    cards.nth(1).hover()
    assert shown(page) == stain(page)["second"] > 0.2 * left["model"]
    cards.first.hover()
    assert shown(page) < 2.0
    cards.first.click()
    page.wait_for_function("document.querySelectorAll('.rung').length == 2")
    assert abs(chi2_of_rungs(page)[1] - 1.0) < 0.3  # four standard errors of a floor that is known to 7 %
    page.get_by_text("At the noise floor").wait_for()
    page.reload()
    page.wait_for_function("document.querySelectorAll('.rung').length == 2")

    told = subprocess.run(
        [sys.executable, "-m", "station", "refine", "walk", "--json", "--no-viewer"],
        cwd=bench.folder, capture_output=True, text=True, timeout=180, check=True,
    )  # fmt: skip
    rungs = json.loads(told.stdout)["rungs"]
    assert [rung["added"] for rung in rungs] == [None, "stribeck_friction"]
    assert abs(rungs[1]["error"]["chi2"] - chi2_of_rungs(page)[1]) < 0.001

    page.locator(".rung").first.click()
    page.wait_for_selector(".rung.above")
    assert json.loads((bench.results("walk") / "ladder.json").read_text())["present"] == 0


@pytest.mark.slow
def test_the_report_of_a_session_is_written_from_the_page(visit, bench):
    page = visit.page
    page.goto(bench.fresh("mystery_7", "reported"))
    page.wait_for_selector(".rung")
    page.get_by_role("button", name="Write the report of this session").click()
    report = page.get_by_role("link", name="Open the report")
    report.wait_for()
    text = page.request.get(bench.address + report.get_attribute("href")).text()
    assert "coulomb" in text.lower()
    assert "http://" not in text.replace("http://www.w3.org", "")


def test_every_axis_has_a_unit_and_the_same_moment_is_marked_in_all_pictures(visit, bench):
    page = visit.page
    page.goto(bench.fresh("mystery_12", "linked"))
    page.wait_for_selector(".rung")
    page.wait_for_function("Object.values(window.bench.plots ?? {}).filter(p => p.names).length == 3")
    names = [name for pair in page.evaluate("Object.values(bench.plots).map(p => p.names)") for name in pair]
    assert len(names) == 6
    assert all(re.search(r"\[.+\]$", name) for name in names)
    page.locator("[data-plot=left]").hover(position={"x": 200, "y": 60})
    page.wait_for_function(
        "[...document.querySelectorAll('.mark')].filter(m => m.style.display == 'block').length == 3"
    )
    assert re.match(r"t = \d\.\d{3} s", page.locator("#readout").inner_text())


@pytest.mark.slow
def test_an_effect_of_ones_own_is_checked_as_it_is_typed_and_can_be_switched_off_and_on(visit, bench):
    page = visit.page
    page.goto(bench.fresh("mystery_12", "own"))
    page.wait_for_selector(".rung")
    field = page.get_by_role("textbox", name="Effect of your own")
    add = page.get_by_role("button", name="Add the effect of your own")
    field.fill("drag = c*w(v)")
    page.get_by_text("there is no function 'w'").wait_for()
    assert add.is_disabled()
    field.fill("drag = c*v*abs(v)")
    add.and_(
        page.locator(":enabled")
    ).wait_for()  # the sentence changes as soon as it is fitted and previewed
    add.click()
    page.wait_for_function("document.querySelectorAll('.rung').length == 2")
    assert abs(chi2_of_rungs(page)[1] - 1.0) < 0.3
    page.get_by_role("switch", name="drag in the model").click()
    page.wait_for_function("document.querySelectorAll('.rung').length == 3")
    assert chi2_of_rungs(page)[2] > 10
    page.get_by_role("switch", name="drag in the model").click()
    page.wait_for_function("document.querySelectorAll('.rung').length == 4")
    assert abs(chi2_of_rungs(page)[3] - 1.0) < 0.3


@pytest.mark.slow
def test_a_computation_is_cancelled_and_the_next_one_works(visit, bench):
    page = visit.page
    page.goto(bench.fresh("mystery_7", "cancelled"))
    page.wait_for_selector(".rung")
    page.wait_for_function(
        "/the measured motion/.test(document.querySelector('#statement .more').textContent)"
    )
    kept = {path.name: path.read_bytes() for path in bench.results("cancelled").iterdir()}
    rungs = page.locator(".rung").count()
    page.get_by_role("button", name="Diagnose").click()
    page.get_by_role("button", name="Cancel", exact=True).click()
    page.get_by_text("cancelled; nothing was changed").wait_for()
    assert {path.name: path.read_bytes() for path in bench.results("cancelled").iterdir()} == kept
    page.get_by_role("textbox", name="Effect of your own").fill("extra = q*u**5")
    page.get_by_role("button", name="Add the effect of your own").click()
    page.wait_for_function("document.querySelector('.rung.present')?.innerText.includes('extra')")
    assert page.locator(".rung").count() <= rungs + 1


@pytest.mark.slow
def test_two_tabs_on_two_sessions_do_not_disturb_each_other(visit, bench):
    first, second = visit.page, visit.page.context.new_page()
    first.goto(bench.fresh("mystery_7", "tab_one"))
    second.goto(bench.fresh("mystery_12", "tab_two"))
    for page in (first, second):
        page.wait_for_selector(".rung")
    rungs = second.locator(".rung").count()
    first.get_by_role("button", name="Diagnose").click()
    second.locator(".rung").first.click()
    second.wait_for_selector(".rung.present:first-of-type")
    assert second.locator(".rung").count() == rungs
    first.wait_for_selector("button.card-suspect")
    first.get_by_role("button", name="Diagnose again").click()
    first.wait_for_function("!document.querySelector('[inert]')")
    assert first.locator(".verdict").count() == 1


@pytest.mark.slow
def test_two_tabs_on_one_session_show_the_same(visit, bench):
    first, second = visit.page, visit.page.context.new_page()
    address = bench.fresh("mystery_12", "shared")
    for page in (first, second):
        page.goto(address)
        page.wait_for_selector(".rung")
    first.get_by_role("textbox", name="Effect of your own").fill("shared = c*v*abs(v)")
    first.get_by_role("button", name="Add the effect of your own").click()
    for page in (first, second):
        page.wait_for_function("document.querySelectorAll('.rung').length == 2")
    assert chi2_of_rungs(first) == chi2_of_rungs(second)


@pytest.mark.slow
def test_reruns_viewer_opens_in_the_page_and_asks_nobody_else(visit, bench):
    page = visit.page
    page.goto(bench.fresh("mystery_12", "viewed"))
    page.wait_for_selector(".rung")
    with (
        page.expect_response(lambda answer: answer.url.endswith("re_viewer_bg.wasm")) as got,
        page.expect_response(lambda answer: "/viewer/recording/" in answer.url) as read,
    ):
        page.get_by_role("tab", name="3-D / Rerun").click()
    assert got.value.status == read.value.status == 200
    recording = next(url for url in visit.asked if "viewer/index.html" in url)
    assert "viewed.rrd" in recording
    assert (bench.results("viewed") / "identification.rrd").stat().st_size > 100_000
