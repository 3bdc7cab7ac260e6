"""Who may speak to the workbench: this computer's browser on its own page, and nobody else."""

import asyncio
import gzip
import http.client
import re
import socket
from urllib.parse import parse_qs, urlsplit

import pytest
from starlette.exceptions import HTTPException

from station.workbench.guard import LARGEST_BODY, Guard
from station.workbench.uploads import plain_name


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


def test_a_name_that_was_made_to_point_here_is_refused(bench):
    assert ask(bench, Host="evil.example").status == 403
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


def test_the_browser_is_sent_to_the_page_without_the_token_among_its_arguments(tmp_path):
    from station.workbench.server import _way_to

    address = _way_to("http://127.0.0.1:1/?session=a&token=secret", tmp_path)
    assert "secret" not in address
    assert 'url=http://127.0.0.1:1/?session=a&amp;token=secret"' in (tmp_path / "open.html").read_text()


def test_a_request_of_half_a_gigabyte_is_refused_before_it_is_read(bench):
    place = urlsplit(bench.address)
    head = (
        f"POST /_nicegui/client/x/upload/1 HTTP/1.1\r\nHost: {place.netloc}\r\nCookie: {cookie_of(bench)}\r\n"
    )
    for length in (500_000_000, LARGEST_BODY + 1):
        with socket.create_connection((place.hostname, place.port), timeout=10) as line:
            line.sendall(f"{head}Content-Length: {length}\r\n\r\n".encode())
            assert b" 413 " in line.recv(100)


def test_a_body_of_unsaid_length_is_cut_off_at_the_limit():
    taken = []

    async def app(scope, receive, send):
        while True:
            taken.append(len((await receive())["body"]))

    async def receive():
        return {"type": "http.request", "body": bytes(1 << 20), "more_body": True}

    guard = Guard(app, {"127.0.0.1:1"}, "secret")
    headers = [(b"host", b"127.0.0.1:1"), (b"cookie", b"workbench-1=secret")]
    scope = {
        "type": "http",
        "method": "POST",
        "path": "/",
        "query_string": b"",
        "headers": headers,
        "server": ("127.0.0.1", 1),
    }
    with pytest.raises(HTTPException) as refused:
        asyncio.run(guard(scope, receive, None))
    assert refused.value.status_code == 413
    assert sum(taken) <= LARGEST_BODY


def test_what_is_no_part_of_the_viewer_is_not_served(bench):
    for path in (
        "/viewer/..%2f..%2fetc%2fpasswd",
        "/viewer/session.json",
        "/viewer/recording/1/..%2fmystery_7.rrd",
    ):
        assert ask(bench, path).status == 404


@pytest.mark.parametrize(
    ("given", "kept"),
    [
        ("decay.csv", "decay.csv"),
        ("../../.ssh/authorized_keys", "authorized_keys"),
        ("C:\\Windows\\decay.MAT", "decay.MAT"),
        ("<b>x</b>.csv", "b.csv"),
        ("..", "recording"),
        ("\x00.csv", "recording.csv"),
        ("ä ö.csv", "ä_ö.csv"),
    ],
)
def test_a_file_name_leads_out_of_no_folder(given, kept):
    assert plain_name(given) == kept
