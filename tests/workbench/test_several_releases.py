"""Several releases of one bench on the page: diagnosed together, and tabulated with their mean."""

import json
import re
import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from daq.capture import CaptureSettings, capture
from daq.session_info import SessionInfo
from tests.workbench.conftest import mystery_board

pytestmark = pytest.mark.slow
NAMES = ("pair_one", "pair_two")
SEED = 12
"""Hides quadratic damping, see conftest."""


def recorded(bench):
    """Record two releases of one bench; return what it hides, as its envelope says."""
    with TemporaryDirectory() as aside:
        envelope = Path(aside) / "truth.json"
        with mystery_board(SEED, envelope) as port:
            for name in NAMES:
                shutil.rmtree(bench.folder / "sessions" / name, ignore_errors=True)
                info = SessionInfo(name=name, mass_kg=21.36)
                wanted = CaptureSettings(duration_s=4.0, check_clock=False, info=info)
                capture(port, wanted, bench.folder / "sessions" / name)
        return json.loads(envelope.read_text())


def numbers(row):
    """Return the values of a row's cells without their errors, by column; what is not a number is left out."""
    cells = [cell.inner_text() for cell in row.locator("td").all()]
    found = {n: re.match(r"-?\d+(\.\d+)?(?=\s±)", cell) for n, cell in enumerate(cells)}
    return {n: float(match[0]) for n, match in found.items() if match}


def test_two_releases_of_one_bench_are_diagnosed_together_both_keep_the_answer_and_table_2_gives_their_mean(
    visit, bench
):
    page, made_of = visit.page, recorded(bench)
    page.goto(bench.session(NAMES[0]))
    page.wait_for_selector(".step")
    page.get_by_role("button", name="Choose releases to look at together").locator("visible=true").click()
    page.get_by_role("checkbox", name=NAMES[1]).click()
    page.keyboard.press("Escape")
    page.get_by_text("With 1 other").locator("visible=true").wait_for()
    page.get_by_role("button", name=re.compile(r"^Diagnose( again)?$")).click()
    page.wait_for_selector("button.card-suspect")
    assert "quadratic damping" in page.locator(".verdict").inner_text()
    kept = [
        json.loads((bench.folder / "sessions" / name / "results" / "diagnosis.json").read_text())
        for name in NAMES
    ]
    assert kept[0] == kept[1]
    assert sorted(kept[0]["sessions"]) == sorted(NAMES)  # the larger release first, and they are as large
    first = kept[0]["suspects"][0]
    found, truth = first["parameters"]["c2"], made_of["parameters"][made_of["hidden"]]["c2"]
    assert first["effect"] == made_of["hidden"]
    assert abs(found["value"] - truth) < 4.0 * found["std"]

    page.get_by_role("tab", name="Identification").click()
    page.get_by_text("its values may be quoted").wait_for()
    page.get_by_text("Table 2. Mean and standard deviation over 2 releases").wait_for()
    tables = page.locator(".numbers-table")
    means = [numbers(row) for row in tables.last.locator("tbody tr").all()]
    for k, mean in enumerate(means):
        one, two = (numbers(row) for row in tables.nth(1 + k).locator("tbody tr").all())
        assert (
            set(one) == set(two) == set(mean) == {2, 3}
        )  # after name and amplitude, or unit: the two methods
        for column in (2, 3):
            half = 0.5 * abs(one[column] - two[column])
            wanted = pytest.approx(
                0.5 * (one[column] + two[column]), abs=0.1 * half + 0.01 * abs(mean[column])
            )
            assert mean[column] == wanted
