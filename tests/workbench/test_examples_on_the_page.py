"""Whoever has no board opens an example from the empty page."""

import re

import pytest

from station.operations.examples import EXAMPLES


@pytest.fixture
def empty_page(visit, bench):
    """Put the sessions of the other tests aside, so that the page has none."""
    sessions, aside = bench.folder / "sessions", bench.folder / "aside"
    sessions.rename(aside)
    sessions.mkdir()
    visit.page.goto(bench.address)
    yield visit.page
    visit.page.goto("about:blank")
    sessions.rename(bench.folder / "opened")
    aside.rename(sessions)


@pytest.mark.slow
def test_an_example_is_opened_from_the_empty_page(empty_page):
    page = empty_page
    page.get_by_text("No session yet.").wait_for()
    offered = page.get_by_role("button", name=re.compile("Open the example"))
    assert offered.count() == len(EXAMPLES)
    page.get_by_role("button", name=re.compile("Open the example simulated_stribeck")).click()
    page.wait_for_url(re.compile("session=simulated_stribeck"))
    page.wait_for_selector(".step")
    assert float(page.locator(".step .value").first.inner_text()) > 10
