"""Who may speak to the workbench: this computer's browser on its own page, and nobody else."""

import http.client
from urllib.parse import urlsplit

import pytest

from station.workbench.uploads import plain_name


def ask(bench, path="/", **headers):
    place = urlsplit(bench.address)
    connection = http.client.HTTPConnection(place.hostname, place.port, timeout=10)
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    answer.read()
    connection.close()
    return answer


def test_the_page_may_fetch_nothing_from_elsewhere(bench):
    policy = ask(bench).headers["Content-Security-Policy"]
    place = urlsplit(bench.address).netloc
    sources = {word for part in policy.split("; ") for word in part.split()[1:]}
    assert sources <= {
        "'self'",
        "'none'",
        "'unsafe-inline'",
        "'unsafe-eval'",
        "data:",
        "blob:",
        f"ws://{place}",
    }
    assert "default-src 'self'" in policy


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
