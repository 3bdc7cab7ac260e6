"""What goes wrong at a bench: a wrong file, a stalled board, a session that strangers named."""

import json
import math
import shutil

import pytest

from mocks.in_process import running

pytestmark = pytest.mark.slow  # each walks through a browser


def test_a_file_that_is_no_recording_is_refused_in_words_and_the_next_becomes_a_session_within_the_folder(
    visit, bench
):
    import numpy as np

    page = visit.page
    page.goto(bench.address)
    before = sorted(path.name for path in (bench.folder / "sessions").iterdir())
    wrong = {"name": "holiday.csv", "mimeType": "text/csv", "buffer": b"dear diary,\nthe sea was calm\n" * 40}
    page.locator(".drop input[type=file]").set_input_files(wrong)
    page.locator("aside .bad.small").first.wait_for()
    told = page.locator("aside .bad.small").first.inner_text()
    assert "holiday.csv" in told
    assert "/tmp" not in told
    assert "fault of this program" not in told
    assert sorted(path.name for path in (bench.folder / "sessions").iterdir()) == before
    time_s = np.arange(1200) / 200.0
    u = 0.02 * np.exp(-0.2 * time_s) * np.cos(25.0 * time_s) + 5e-6 * np.random.default_rng(1).normal(
        size=1200
    )
    lines = ["time_s,displacement_m", *(f"{t:.4f},{x:.8f}" for t, x in zip(time_s, u, strict=True))]
    named = {"name": "..\\..\\decay <b>.csv", "mimeType": "text/csv", "buffer": "\n".join(lines).encode()}
    page.locator(".drop input[type=file]").set_input_files(named)
    page.wait_for_selector(".step")  # it is opened
    page.get_by_text("was imported").wait_for()
    assert (bench.folder / "sessions" / "decay_b" / "session.json").is_file()


def test_a_file_that_does_not_explain_itself_shows_its_columns_and_is_read_as_they_are_said_to_be(
    visit, bench
):
    rows = [f"{i / 50},{0.1 * math.cos(2.4 * i / 50):.5f},{0.02 * math.sin(i / 50):.5f}" for i in range(1500)]
    text = "\n".join(["time,phi,theta", *rows]).encode()
    page = visit.page
    page.goto(bench.address)
    drop = page.locator(".drop input[type=file]")
    drop.set_input_files({"name": "odd.csv", "mimeType": "text/csv", "buffer": text})
    page.get_by_text("2 columns could be the displacement").wait_for()
    unit = page.get_by_label("Unit of column 2 'phi'")
    unit.click()
    page.get_by_role("option", name="deg", exact=True).click()
    page.get_by_role("button", name="Read odd.csv so").click()
    page.wait_for_url("**session=odd**")
    recipe = (bench.folder / "sessions" / "odd" / "recipe.toml").read_text(encoding="utf-8")
    assert '{name = "phi", role = "displacement", unit = "deg"}' in recipe
    page.goto(bench.address)
    page.goto(bench.address)
    drop.set_input_files({"name": "next.csv", "mimeType": "text/csv", "buffer": text})
    page.wait_for_url("**session=next")


def test_several_files_of_one_logger_run_through_a_campaign_by_one_answer(visit, bench):
    rows = [
        [(i / 50, 30.0 * math.exp(-0.004 * n * i) * math.cos(0.12 * i)) for i in range(1500)] for n in (1, 2)
    ]
    files = [
        {"name": f"arm{n}.csv", "mimeType": "text/csv",
         "buffer": "\n".join(f"{t:.2f} {x:.4f}" for t, x in one).encode()}
        for n, one in enumerate(rows, start=1)
    ]  # fmt: skip
    page = visit.page
    page.goto(bench.address)
    page.locator(".drop input[type=file]").set_input_files(files)
    page.get_by_text("The other 1 files are read alike").wait_for()
    unit = page.get_by_label("Unit of column 2")
    page.get_by_role("button", name="Read 2 files so").click()
    page.get_by_text("choose the unit of the displacement").wait_for()  # nothing in the file says it
    unit.click()
    page.get_by_role("option", name="deg", exact=True).click()
    page.get_by_label("Numbers in the names of files").fill("arm{n:d}.csv")
    page.get_by_label("What varies between them").fill("damping")
    page.get_by_role("button", name="Read 2 files so").click()
    page.get_by_text("2 sessions identified").wait_for()
    known = json.loads((bench.folder / "sessions" / "arm2" / "session.json").read_text(encoding="utf-8"))
    assert known["conditions"] == {"n": 2.0}
    assert known["varies"] == ["damping"]


def test_a_record_that_is_too_short_says_so_and_so_does_a_damaged_one(visit, bench):
    short = bench.folder / "short.csv"
    rows = [f"{i / 100},{0.01 * math.cos(6 * i / 100):.6f}" for i in range(100)]
    short.write_text("\n".join(["time_s,displacement_m", *rows]))
    page = visit.page
    page.goto(bench.address)
    page.locator(".drop input[type=file]").set_input_files(short)
    page.get_by_text("This recording does not allow an analysis").wait_for()
    page.get_by_text("at least three cycles").first.wait_for()
    address = bench.fresh("mystery_7", "damaged")
    (bench.folder / "sessions" / "damaged" / "session.json").write_text("{")
    page.goto(address)
    page.get_by_text("This recording does not allow an analysis").wait_for()
    assert "Errno" not in page.locator(".bench-columns").inner_text()
    assert "fault of this program" not in page.locator(".bench-columns").inner_text()


def test_a_board_that_falls_silent_is_reported_and_what_came_is_kept(visit, bench):
    page = visit.page
    page.goto(bench.address)
    with running("--tcp", "0", "--fault", "stall:30@1.5") as port:
        field = page.get_by_label("Port of the board")
        field.fill(port)
        field.press("Enter")
        page.get_by_role("button", name="Arm the capture").click()
        page.get_by_text("nothing came for 0.5 s").wait_for()
        page.get_by_text("silent for 2 s").wait_for()
    page.get_by_role("button", name="Arm the capture").wait_for()
    page.locator(".session", has_text="aborted").first.wait_for()


def test_a_session_that_a_stranger_named_is_only_text(visit, bench):
    name = "<img src=x onerror=alert(1)>"
    bench.fresh("mystery_7", name)
    page = visit.page
    try:
        page.goto(bench.address)
        page.locator(".session", has_text="<img").click()
        page.wait_for_selector(".step")
        assert page.locator(".bench-session").inner_text() == name
        assert page.locator("img").count() == 0
    finally:
        shutil.rmtree(bench.folder / "sessions" / name)


def test_an_address_leads_nowhere_but_to_stored_sessions(visit, bench):
    page = visit.page
    page.goto(f"{bench.address}/?session=..%2F..%2Fetc")
    page.get_by_text("There is no session called ../../etc").wait_for()
