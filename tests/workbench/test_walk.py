"""The page as it runs: who may speak to it, and a newcomer's walk with the mouse to the right effect and the floor."""

import gzip
import http.client
import json
import re
import socket
import subprocess
import sys
from urllib.parse import parse_qs, urlsplit

import pytest

from station.workbench.guard import LARGEST_BODY

STAIN = """f => f.force.map((force, i) => (force / f.force_std[i]) ** 2).reduce((a, b) => a + b, 0) / f.force.length"""


def shown(page):
    return page.evaluate(f"({STAIN})(bench.shown())")


def stain(page):
    return page.evaluate(
        f"""(() => {{ const s = bench.state, of = {STAIN}, names = Object.values(s.suspects);
        return {{model: of(s.frames[s.steps[s.present]]), second: of(s.frames[names[1]])}} }})()"""
    )


def residual_of_steps(page):
    return [float(text) for text in page.locator(".step .value").all_inner_texts()]


def every_axis_has_a_unit(page):
    page.wait_for_function("['map', 'traces'].every(n => bench.chart(n)?.getOption()?.series?.length)")
    names = page.evaluate("""() => { const [map, traces] = ["map", "traces"].map(n => bench.chart(n).getOption());
      return [...map.xAxis, ...map.yAxis, traces.xAxis[1]].map(a => a.name).concat(traces.title.map(t => t.text)) }""")
    assert len(names) == 5
    assert all(re.search(r"\[.+\]", name) for name in names), names
    assert all(" N" in text for text in page.evaluate("bench.chart('map').getOption().visualMap[0].text"))


def test_a_newcomer_reads_units_on_every_axis_finds_the_hidden_effect_and_reaches_the_floor(visit, bench):
    page = visit.page
    bench.fresh("mystery_7", "walk")
    page.goto(bench.address)
    page.get_by_role("link", name=re.compile("walk")).click()
    page.wait_for_selector(".step")
    before = residual_of_steps(page)
    assert len(before) == 1
    assert before[0] > 10
    every_axis_has_a_unit(page)
    page.mouse.move(300, 600)
    page.mouse.move(330, 640)  # where the cards will be
    page.get_by_role("button", name="Diagnose").press("Enter")
    page.wait_for_selector("button.card-suspect")
    assert "Stribeck friction" in page.locator(".verdict").inner_text()
    page.wait_for_function("Object.keys(bench.state.suspects).length >= 3")
    left = stain(page)
    assert (
        left["model"] > 5
    )  # mean square of the missing force in units of its noise, cell by cell; noise has 1
    assert page.evaluate("document.elementFromPoint(330, 640).closest('.card-suspect') !== null")
    assert (
        page.evaluate("bench.state.pointed") is None
    )  # a card that slid under the pointer was not pointed at
    assert page.evaluate("bench.state.selected") == "stribeck_friction"  # what is named is looked at first
    assert page.evaluate("bench.chart('map').getOption().title.length") == 2  # before and after, side by side
    assert shown(page) < 2.0
    cards = page.locator("button.card-suspect")
    cards.nth(1).hover()
    assert shown(page) == stain(page)["second"] > 0.2 * left["model"]
    cards.nth(1).click()
    page.mouse.move(640, 5)
    assert shown(page) == stain(page)["second"]  # what was clicked stays
    cards.first.click()
    assert shown(page) < 2.0
    page.get_by_role("button", name="Add Stribeck friction").click()
    page.wait_for_function("document.querySelectorAll('.step').length == 2")
    assert abs(residual_of_steps(page)[1] - 1.0) < 0.3  # four standard errors of a floor that is known to 7 %
    page.get_by_text("At the noise floor").wait_for()
    page.get_by_role("button", name="Reveal the mystery").click()
    page.get_by_text(
        re.compile(r"The simulated board hid Stribeck friction.*\(dmu = [\d.]+\sN, vs = ")
    ).wait_for()
    page.reload()
    page.wait_for_function("document.querySelectorAll('.step').length == 2")

    told = subprocess.run(
        [sys.executable, "-m", "station", "refine", "walk", "--json", "--no-viewer"],
        cwd=bench.folder, capture_output=True, text=True, timeout=180, check=True,
    )  # fmt: skip
    steps = json.loads(told.stdout)["steps"]
    assert [step["added"] for step in steps] == [None, "stribeck_friction"]
    assert abs(steps[1]["error"]["chi2"] ** 0.5 - residual_of_steps(page)[1]) < 0.001

    page.locator(".step").first.click()
    page.wait_for_selector(".step.above")
    assert json.loads((bench.results("walk") / "ladder.json").read_text())["present"] == 0


@pytest.mark.slow
def test_an_effect_of_ones_own_is_checked_as_it_is_typed_and_switched_off_and_on_in_every_tab(visit, bench):
    page, other = visit.page, visit.page.context.new_page()
    address = bench.fresh("mystery_12", "own")
    for one in (page, other):
        one.goto(address)
        one.wait_for_selector(".step")
    field = page.get_by_role("textbox", name="Effect of your own")
    add = page.get_by_role("button", name="Add the effect of your own")
    field.fill("drag = c*w(v)")
    page.get_by_text("there is no function 'w'").wait_for()
    assert add.is_disabled()
    field.fill("drag = c*v*abs(v)")
    add.and_(
        page.locator(":enabled")
    ).wait_for()  # the sentence changes as soon as it is fitted and previewed
    assert page.get_by_text(re.compile(r"^[\d.]+ % of the motion with drag")).count() == 1
    add.click()
    page.wait_for_function("document.querySelectorAll('.step').length == 2")
    assert abs(residual_of_steps(page)[1] - 1.0) < 0.3
    page.get_by_role("switch", name="drag in the model").click()
    page.wait_for_function("document.querySelectorAll('.step').length == 3")
    assert residual_of_steps(page)[2] > 10
    page.get_by_role("switch", name="drag in the model").click()
    for one in (page, other):
        one.wait_for_function("document.querySelectorAll('.step').length == 4")
    assert abs(residual_of_steps(page)[3] - 1.0) < 0.3
    assert residual_of_steps(other) == residual_of_steps(page)


@pytest.mark.slow
def test_a_computation_disturbs_no_other_tab_is_cancelled_and_begun_again(visit, bench):
    first, second = visit.page, visit.page.context.new_page()
    first.goto(bench.fresh("mystery_7", "tab_one"))
    second.goto(bench.fresh("mystery_12", "tab_two"))
    for page in (first, second):
        page.wait_for_selector(".step")
        page.wait_for_function(
            "/the measured motion/.test(document.querySelector('#statement .more').textContent)"
        )
    kept = {path.name: path.read_bytes() for path in bench.results("tab_one").iterdir()}
    steps = second.locator(".step").count()
    first.get_by_role("button", name="Diagnose").click()
    second.locator(".step").first.click()
    second.wait_for_selector(".step.present:first-of-type")
    assert second.locator(".step").count() == steps
    first.get_by_role("button", name="Cancel", exact=True).click()
    first.get_by_text("cancelled; nothing was changed").wait_for()
    assert {path.name: path.read_bytes() for path in bench.results("tab_one").iterdir()} == kept
    first.get_by_role("button", name="Diagnose").click()
    first.wait_for_selector("button.card-suspect")
    first.wait_for_function("!document.querySelector('[inert]')")
    assert first.locator(".verdict").count() == 1


@pytest.mark.slow
def test_reruns_viewer_opens_in_the_page_and_asks_nobody_else(visit, bench):
    page = visit.page
    page.goto(bench.fresh("mystery_12", "viewed"))
    page.wait_for_selector(".step")
    with (
        page.expect_response(lambda answer: answer.url.endswith("re_viewer_bg.wasm")) as got,
        page.expect_response(lambda answer: "/viewer/recording/" in answer.url) as read,
    ):
        page.get_by_role("tab", name="3-D / Rerun").click()
    assert got.value.status == read.value.status == 200
    recording = next(url for url in visit.asked if "viewer/index.html" in url)
    assert "viewed.rrd" in recording
    assert (bench.results("viewed") / "identification.rrd").stat().st_size > 100_000


def ask(bench, path="/", method="GET", token=True, **headers):
    place = urlsplit(bench.address)
    if token:
        headers["Cookie"] = f"{{odd=[1,2]; a=b; {cookie_of(bench)}"
    connection = http.client.HTTPConnection(place.hostname, place.port, timeout=10)
    connection.request(method, path, headers=headers)
    answer = connection.getresponse()
    answer.read()
    connection.close()
    return answer


def cookie_of(bench):
    printed = urlsplit(bench.printed)
    return f"workbench-{printed.port}={parse_qs(printed.query)['token'][0]}"


def test_the_page_may_fetch_nothing_from_elsewhere(bench):
    policy = ask(bench).headers["Content-Security-Policy"]
    place = urlsplit(bench.address).netloc
    sources = {word for part in policy.split("; ") for word in part.split()[1:]}
    (nonce,) = {word for word in sources if word.startswith("'nonce-")}
    assert sources - {nonce} <= {
        "'self'",
        "'none'",
        "'unsafe-inline'",
        "'unsafe-eval'",
        "data:",
        "blob:",
        f"ws://{place}",
    }
    assert "default-src 'self'" in policy


def test_of_scripts_in_the_page_those_that_the_server_wrote_are_run(bench):
    place = urlsplit(bench.address)
    connection = http.client.HTTPConnection(place.hostname, place.port, timeout=10)
    connection.request("GET", "/", headers={"Cookie": cookie_of(bench), "Accept-Encoding": "gzip"})
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    page = gzip.decompress(body) if answer.headers.get("Content-Encoding") == "gzip" else body
    scripts = next(
        p for p in answer.headers["Content-Security-Policy"].split("; ") if p.startswith("script-src")
    )
    assert "unsafe-inline" not in scripts
    nonce = re.search(r"'nonce-([^']+)'", scripts)[1]
    assert page.count(b"<script") == page.count(f'<script nonce="{nonce}"'.encode()) > 3
    assert nonce not in ask(bench).headers["Content-Security-Policy"]


def test_a_report_that_a_stranger_wrote_runs_no_script(bench):
    bench.fresh("mystery_7", "foreign")
    bench.results("foreign").mkdir(exist_ok=True)
    (bench.results("foreign") / "report.html").write_text("<script>alert(1)</script>")
    place = urlsplit(bench.address)
    connection = http.client.HTTPConnection(place.hostname, place.port, timeout=10)
    connection.request("GET", "/report/foreign", headers={"Cookie": cookie_of(bench)})
    answer = connection.getresponse()
    assert answer.read() == b"<script>alert(1)</script>"  # it gets no nonce
    connection.close()
    policy = answer.headers["Content-Security-Policy"]
    assert policy.startswith("sandbox allow-modals; default-src 'none'")
    assert "script-src" not in policy


def test_a_name_that_was_made_to_point_here_is_refused(bench):
    """A browser sends the cookie to the name alone by which it got it."""
    assert ask(bench, token=False, Host="evil.example").status == 403
    assert ask(bench).status == 200


UPGRADE = {
    "Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
}  # fmt: skip
SOCKET = "/_nicegui_ws/socket.io/?EIO=4&transport=websocket"


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://127.0.0.1:1"])
def test_a_websocket_of_another_site_is_refused(bench, origin):
    assert ask(bench, SOCKET, Origin=origin, **UPGRADE).status == 403
    assert ask(bench, Origin=origin).status == 403


PLACES = [
    "/", "/?session=mystery_7", "/?token=", "/?token=guessed", "/static/bench/bench.js", "/report/mystery_7",
    "/_nicegui_ws/socket.io/?EIO=4&transport=polling", "/viewer/index.html", "/favicon.ico", "/no/such/page",
]  # fmt: skip


@pytest.mark.parametrize("path", PLACES)
def test_another_user_of_this_computer_gets_nothing_without_the_token(bench, path):
    for method in ("GET", "HEAD", "POST", "OPTIONS", "DELETE"):
        answer = ask(bench, path, method, token=False)
        assert answer.status == 403
        assert answer.headers["Set-Cookie"] is None
    assert ask(bench, path, token=False, Cookie=f"{cookie_of(bench)}x").status == 403


def test_a_websocket_without_the_token_is_refused(bench):
    assert ask(bench, SOCKET, **UPGRADE).status == 101
    assert ask(bench, SOCKET, token=False, **UPGRADE).status == 403
    query = urlsplit(bench.printed).query
    assert ask(bench, f"{SOCKET}&{query}", token=False, **UPGRADE).status == 403


def test_the_printed_address_is_answered_by_a_cookie_and_the_address_without_the_token(bench):
    query = urlsplit(bench.printed).query
    answer = ask(bench, f"//evil.example/x?session=a%26b&{query}", token=False)
    assert answer.status == 303
    assert answer.headers["Location"] == "/evil.example/x?session=a%26b"
    kept = answer.headers["Set-Cookie"]
    assert kept.startswith(cookie_of(bench))
    assert {"HttpOnly", "SameSite=lax"} <= set(kept.split("; "))
    assert ask(bench, f"/?{query}", "POST", token=False).status == 403


def test_a_request_of_half_a_gigabyte_is_refused_before_it_is_read(bench):
    place = urlsplit(bench.address)
    head = (
        f"POST /_nicegui/client/x/upload/1 HTTP/1.1\r\nHost: {place.netloc}\r\nCookie: {cookie_of(bench)}\r\n"
    )
    for length in (
        "Content-Length: 500000000",
        f"Content-Length: {LARGEST_BODY + 1}",
        "Transfer-Encoding: chunked",
    ):
        with socket.create_connection((place.hostname, place.port), timeout=10) as line:
            line.sendall(f"{head}{length}\r\n\r\n".encode())
            assert b" 413 " in line.recv(100)


def test_what_is_no_part_of_the_viewer_is_not_served(bench):
    for path in (
        "/viewer/..%2f..%2fetc%2fpasswd",
        "/viewer/session.json",
        "/viewer/recording/1/..%2fmystery_7.rrd",
    ):
        assert ask(bench, path).status == 404
