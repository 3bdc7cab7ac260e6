"""The guard and the way to the page, without a page: what is too long is cut off, no name leads elsewhere."""

import asyncio
from concurrent.futures import ThreadPoolExecutor

import pytest
from starlette.exceptions import HTTPException

from station.workbench.guard import LARGEST_BODY, Guard
from station.workbench.stored_sessions import plain_name


def test_the_browser_is_sent_to_the_page_without_the_token_among_its_arguments(tmp_path):
    from station.workbench.server import _way_to

    address = _way_to("http://127.0.0.1:1/?session=a&token=secret", tmp_path)
    assert "secret" not in address
    assert 'url=http://127.0.0.1:1/?session=a&amp;token=secret"' in (tmp_path / "open.html").read_text()


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
    with (
        ThreadPoolExecutor(1) as threads,
        pytest.raises(HTTPException) as refused,
    ):  # a browser's driver may have this one
        threads.submit(asyncio.run, guard(scope, receive, None)).result()
    assert refused.value.status_code == 413
    assert sum(taken) <= LARGEST_BODY


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
